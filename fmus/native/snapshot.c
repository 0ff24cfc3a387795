#include "component.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define M feeddrive_model

/* A snapshot: this head, the State, then per delay line its value, the number
   of changes under way and the changes. */
typedef struct {
    char magic[8];
    uint64_t token, interface, size; /* size of the whole, in bytes */
    uint64_t digest;                 /* of what follows, once it is written */
} Head;

static const char MAGIC[8] = "feeddr2";

static uint64_t digest_of(const void *bytes, size_t size) {
    uint64_t digest = 14695981039346656037u; /* FNV-1a */
    const unsigned char *p = bytes;
    for (size_t i = 0; i < size; i++)
        digest = (digest ^ p[i]) * 1099511628211u;
    return digest;
}

static Head head_of(const Component *c, size_t size) {
    Head head = {.token = digest_of(M.token, strlen(M.token)),
                 .interface = (uint64_t)c->model_exchange,
                 .size = size};
    memcpy(head.magic, MAGIC, sizeof MAGIC);
    return head;
}

static size_t size_now(const Component *c) {
    size_t size = sizeof(Head) + state_size();
    for (unsigned i = 0; i < M.n_delays; i++)
        size += sizeof(double) + sizeof(uint64_t) +
                c->simulation.lines[i].count * sizeof(Change);
    return size;
}

static unsigned char *put(unsigned char *to, const void *from, size_t size) {
    memcpy(to, from, size);
    return to + size;
}

int snapshot_take(Component *c, const char *function, void **snapshot) {
    if (!component_may(c, function, SOUND))
        return STATUS_ERROR;
    if (!snapshot)
        return component_refuse(c, "%s: no place for the state was given", function);
    size_t size = size_now(c);
    unsigned char *p = realloc(*snapshot, size);
    if (!p)
        return component_refuse(c, "%s: there is no memory for the state", function);
    *snapshot = p;
    Head head = head_of(c, size);
    p = put(p, &head, sizeof head);
    p = put(p, c->simulation.state, state_size());
    for (unsigned i = 0; i < M.n_delays; i++) {
        const DelayLine *line = c->simulation.lines + i;
        uint64_t count = line->count;
        p = put(p, &line->value, sizeof(double));
        p = put(p, &count, sizeof count);
        if (count)
            p = put(p, line->changes + line->first, line->count * sizeof(Change));
    }
    return STATUS_OK;
}

/* Read one line from the bytes p..end; returns what follows it, or NULL. */
static const unsigned char *read_line(const unsigned char *p,
                                      const unsigned char *end, DelayLine *line) {
    uint64_t count;
    if ((size_t)(end - p) < sizeof(double) + sizeof count)
        return NULL;
    memcpy(&line->value, p, sizeof(double));
    memcpy(&count, p + sizeof(double), sizeof count);
    p += sizeof(double) + sizeof count;
    if (count > (size_t)(end - p) / sizeof(Change))
        return NULL;
    size_t size = (size_t)count * sizeof(Change);
    free(line->changes);
    line->changes = size ? malloc(size) : NULL;
    line->first = 0;
    line->count = line->capacity = line->changes ? (size_t)count : 0;
    if (size && !line->changes)
        return NULL;
    if (size)
        memcpy(line->changes, p, size);
    return p + size;
}

/* Tell whether bytes are a whole snapshot of this model; if they were written,
   they may be foreign or damaged, and a damaged tick would never end. */
static int is_ours(const Component *c, const void *bytes, size_t size, int written) {
    Head head, expected = head_of(c, size);
    if (size < sizeof(Head) + state_size())
        return 0;
    if (written)
        expected.digest =
            digest_of((const unsigned char *)bytes + sizeof(Head), size - sizeof(Head));
    memcpy(&head, bytes, sizeof head);
    if (memcmp(&head, &expected, sizeof head) != 0)
        return 0;
    const unsigned char *p = bytes, *end = p + size;
    p += sizeof(Head) + state_size();
    for (unsigned i = 0; p && i < M.n_delays; i++) {
        DelayLine line = {0};
        p = read_line(p, end, &line);
        delay_free(&line);
    }
    return p == end;
}

static int refuse_foreign(Component *c, const char *function) {
    return component_refuse(c, "%s: this is no state of %s with token %.40s%s",
                            function, M.identifier, M.token,
                            c->model_exchange ? " for model exchange"
                                              : " for co-simulation");
}

static size_t size_of(const void *snapshot) {
    Head head;
    memcpy(&head, snapshot, sizeof head);
    return (size_t)head.size;
}

int snapshot_restore(Component *c, const char *function, const void *snapshot) {
    if (!component_may(c, function, ANY))
        return STATUS_ERROR;
    if (!snapshot || !is_ours(c, snapshot, size_of(snapshot), 0))
        return refuse_foreign(c, function);
    const unsigned char *p = snapshot, *end = p + size_of(snapshot);
    p += sizeof(Head);
    memcpy(c->simulation.state, p, state_size());
    p += state_size();
    for (unsigned i = 0; i < M.n_delays; i++) {
        p = read_line(p, end, c->simulation.lines + i);
        if (!p) {
            c->simulation.state->phase = FAILED;
            return component_refuse(c, "%s: there is no memory for a delayed input",
                                    function);
        }
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
    *size = size_of(snapshot);
    return STATUS_OK;
}

int snapshot_write(Component *c, const char *function, const void *snapshot,
                   unsigned char *bytes, size_t size) {
    if (!component_may(c, function, ANY))
        return STATUS_ERROR;
    if (!snapshot || !bytes || size != size_of(snapshot))
        return component_refuse(c, "%s: the buffer must have the size of the state",
                                function);
    Head head;
    memcpy(bytes, snapshot, size);
    memcpy(&head, snapshot, sizeof head);
    head.digest = digest_of(bytes + sizeof head, size - sizeof head);
    memcpy(bytes, &head, sizeof head);
    return STATUS_OK;
}

int snapshot_read(Component *c, const char *function, const unsigned char *bytes,
                  size_t size, void **snapshot) {
    if (!component_may(c, function, ANY))
        return STATUS_ERROR;
    if (!bytes || !snapshot || !is_ours(c, bytes, size, 1))
        return refuse_foreign(c, function);
    void *copy = realloc(*snapshot, size);
    if (!copy)
        return component_refuse(c, "%s: there is no memory for the state", function);
    Head head = head_of(c, size);
    *snapshot = memcpy(copy, bytes, size);
    memcpy(copy, &head, sizeof head);
    return STATUS_OK;
}
