/* FMU states of a composition with FMUs of others inside, all of which serialise theirs.

   A state is that of the composition, as our FMUs make it (snapshot_own.h), followed by
   the size and the bytes of every FMU inside; there are none before it initialises. */
#include "component.h"
#include "whole.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#pragma GCC diagnostic ignored "-Wunused-function" /* half of what is included */
static int own_take(Component *, const char *, void **);
static int own_restore(Component *, const char *, const void *);
static int own_release(Component *, const char *, void **);
static int own_size(Component *, const char *, const void *, size_t *);
static int own_write(Component *, const char *, const void *, unsigned char *, size_t);
static int own_read(Component *, const char *, const unsigned char *, size_t, void **);
#define snapshot_take own_take
#define snapshot_restore own_restore
#define snapshot_release own_release
#define snapshot_size own_size
#define snapshot_write own_write
#define snapshot_read own_read
#include "snapshot_own.h"
#undef snapshot_take
#undef snapshot_restore
#undef snapshot_release
#undef snapshot_size
#undef snapshot_write
#undef snapshot_read

typedef struct {
    char magic[8];
    uint64_t size, digest; /* of the whole; of what follows, once it is written */
} Cover;

static const char COVER[8] = "feeddrw";

static int append(unsigned char **bytes, size_t *size, const void *from, size_t more) {
    unsigned char *grown = (unsigned char *)realloc(*bytes, *size + more);
    if (!grown)
        return 0;
    if (more)
        memcpy(grown + *size, from, more);
    *bytes = grown;
    *size += more;
    return 1;
}

static int append_foreign(const Component *c, unsigned i, unsigned char **bytes,
                          size_t *size) {
    unsigned char *state = NULL;
    size_t n = 0;
    int done = whole_save(c->simulation.k, i, &state, &n);
    uint64_t told = n;
    done = done && append(bytes, size, &told, sizeof told) && append(bytes, size, state, n);
    free(state);
    return done;
}

int snapshot_take(Component *c, const char *function, void **snapshot) {
    unsigned char *bytes = NULL;
    void *own = NULL;
    size_t size = 0;
    Cover cover;
    int status = snapshot ? own_take(c, function, &own) : own_take(c, function, NULL);
    if (status != STATUS_OK)
        return status;
    memset(&cover, 0, sizeof cover);
    memcpy(cover.magic, COVER, sizeof COVER);
    int done = append(&bytes, &size, &cover, sizeof cover) &&
               append(&bytes, &size, own, snapshot_bytes(own));
    own_release(c, function, &own);
    for (unsigned i = 0; done && i < whole_foreign(); i++)
        done = append_foreign(c, i, &bytes, &size);
    if (!done) {
        free(bytes);
        return component_refuse(c, "%s: an FMU inside does not give its state", function);
    }
    cover.size = size;
    memcpy(bytes, &cover, sizeof cover);
    free(*snapshot);
    *snapshot = bytes;
    return STATUS_OK;
}

static Cover cover_of(const void *snapshot) {
    Cover cover;
    memcpy(&cover, snapshot, sizeof cover);
    return cover;
}

/* The bytes from p on of an FMU's state, or NULL; then *size are there. */
static const unsigned char *foreign_at(const unsigned char *p, const unsigned char *end,
                                       size_t *size) {
    uint64_t told;
    if ((size_t)(end - p) < sizeof told)
        return NULL;
    memcpy(&told, p, sizeof told);
    p += sizeof told;
    *size = (size_t)told;
    return told <= (size_t)(end - p) ? p : NULL;
}

/* Tell whether bytes are a whole state of this FMU. */
static int is_whole(const Component *c, const unsigned char *bytes, size_t size) {
    const unsigned char *p = bytes + sizeof(Cover), *end = bytes + size;
    size_t own, n = 0;
    if (size < sizeof(Cover) + sizeof(Head) ||
        memcmp(bytes, COVER, sizeof COVER) != 0 || cover_of(bytes).size != size)
        return 0;
    own = snapshot_bytes(p);
    if (own > (size_t)(end - p) || !is_ours(c, p, own, 0))
        return 0;
    p += own;
    for (unsigned i = 0; p && i < whole_foreign(); i++) {
        p = foreign_at(p, end, &n);
        p = p ? p + n : NULL;
    }
    return p == end;
}

int snapshot_restore(Component *c, const char *function, const void *snapshot) {
    const unsigned char *bytes = (const unsigned char *)snapshot;
    if (!component_may(c, function, ANY))
        return STATUS_ERROR;
    if (!bytes || !is_whole(c, bytes, (size_t)cover_of(bytes).size))
        return refuse_foreign(c, function);
    const unsigned char *p = bytes + sizeof(Cover), *end = bytes + cover_of(bytes).size;
    int status = own_restore(c, function, p);
    if (status != STATUS_OK)
        return status;
    p += snapshot_bytes(p);
    for (unsigned i = 0; i < whole_foreign(); i++) {
        size_t n = 0;
        p = foreign_at(p, end, &n);
        if (!whole_load(c->simulation.k, i, p, n)) {
            c->simulation.state.phase = FAILED;
            return component_refuse(c, "%s: an FMU inside does not take its state back",
                                    function);
        }
        p += n;
    }
    return STATUS_OK;
}

int snapshot_release(Component *c, const char *function, void **snapshot) {
    if (!component_may(c, function, ANY))
        return STATUS_ERROR;
    if (snapshot) {
        free(*snapshot);
        *snapshot = NULL;
    }
    return STATUS_OK;
}

int snapshot_size(Component *c, const char *function, const void *snapshot,
                  size_t *size) {
    if (!component_may(c, function, ANY))
        return STATUS_ERROR;
    if (!snapshot || !size)
        return component_refuse(c, "%s: no state was given", function);
    *size = (size_t)cover_of(snapshot).size;
    return STATUS_OK;
}

int snapshot_write(Component *c, const char *function, const void *snapshot,
                   unsigned char *bytes, size_t size) {
    if (!component_may(c, function, ANY))
        return STATUS_ERROR;
    if (!snapshot || !bytes || size != cover_of(snapshot).size)
        return component_refuse(c, "%s: the buffer must have the size of the state",
                                function);
    memcpy(bytes, snapshot, size);
    Cover cover = cover_of(snapshot);
    cover.digest = digest_of(bytes + sizeof cover, size - sizeof cover);
    memcpy(bytes, &cover, sizeof cover);
    return STATUS_OK;
}

int snapshot_read(Component *c, const char *function, const unsigned char *bytes,
                  size_t size, void **snapshot) {
    if (!component_may(c, function, ANY))
        return STATUS_ERROR;
    if (!bytes || !snapshot || !is_whole(c, bytes, size) ||
        cover_of(bytes).digest != digest_of(bytes + sizeof(Cover), size - sizeof(Cover)))
        return refuse_foreign(c, function);
    unsigned char *copy = NULL;
    size_t copied = 0;
    if (!append(&copy, &copied, bytes, size))
        return component_refuse(c, "%s: there is no memory for the state", function);
    Cover cover = cover_of(bytes);
    cover.digest = 0;
    memcpy(copy, &cover, sizeof cover);
    free(*snapshot);
    *snapshot = copy;
    return STATUS_OK;
}
