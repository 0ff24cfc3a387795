#include "component.h"

#include "memory.h"

#include <stdint.h>
#include <string.h>

#define M feeddrive_model

/* A snapshot: this head, the State, then per delay line its value, the number
   of changes under way and the changes. */
typedef struct {
    char magic[8];
    uint64_t token, interface, size; /* size of the whole, in bytes */
    uint64_t digest;                 /* of what follows, once it is written */
} Head;

static const char MAGIC[8] = "feeddr3";

static uint64_t digest_of(const void *bytes, size_t size) {
    uint64_t digest = 14695981039346656037u; /* FNV-1a */
    const unsigned char *p = (const unsigned char *)bytes;
    for (size_t i = 0; i < size; i++)
        digest = (digest ^ p[i]) * 1099511628211u;
    return digest;
}

static Head head_of(const Component *c, size_t size) {
    Head head;
    memset(&head, 0, sizeof head);
    memcpy(head.magic, MAGIC, sizeof MAGIC);
    head.token = digest_of(M.token, strlen(M.token));
    head.interface = (uint64_t)c->model_exchange;
    head.size = size;
    return head;
}

static size_t size_fixed(void) {
    return sizeof(Head) + sizeof(State) + simulation_values();
}

static size_t size_now(const Component *c) {
    size_t size = size_fixed();
    for (unsigned i = 0; i < M.n_delays; i++)
        size += sizeof(double) + sizeof(uint64_t) +
                c->simulation.lines[i].count * sizeof(Change);
    return size;
}

static unsigned char *put(unsigned char *to, const void *from, size_t size) {
    memcpy(to, from, size);
    return to + size;
}

static size_t snapshot_bytes(const void *snapshot) {
    Head head;
    memcpy(&head, snapshot, sizeof head);
    return (size_t)head.size;
}

/* Memory of that size in place of what there was; NULL leaves that. */
static unsigned char *renewed(void **snapshot, size_t size) {
    void *memory;
    if (*snapshot && snapshot_bytes(*snapshot) == size)
        return (unsigned char *)*snapshot;
    memory = memory_more(size);
    if (memory) {
        memory_release(*snapshot);
        *snapshot = memory;
    }
    return (unsigned char *)memory;
}

int snapshot_take(Component *c, const char *function, void **snapshot) {
    if (!component_may(c, function, SOUND))
        return STATUS_ERROR;
    if (!snapshot)
        return component_refuse(c, "%s: no place for the state was given", function);
    size_t size = size_now(c);
    unsigned char *p = renewed(snapshot, size);
    if (!p)
        return component_refuse(c, "%s: there is no memory for the state", function);
    Head head = head_of(c, size);
    p = put(p, &head, sizeof head);
    p = put(p, &c->simulation.state, sizeof(State));
    p = put(p, c->simulation.values, simulation_values());
    for (unsigned i = 0; i < M.n_delays; i++) {
        const DelayLine *line = c->simulation.lines + i;
        uint64_t count = line->count;
        p = put(p, &line->value, sizeof(double));
        p = put(p, &count, sizeof count);
        for (size_t k = 0; k < line->count; k++)
            p = put(p, delay_next(line, k), sizeof(Change));
    }
    return STATUS_OK;
}

/* Where the line at the bytes p..end ends, or NULL; count is that of its changes. */
static const unsigned char *line_end(const unsigned char *p, const unsigned char *end,
                                     size_t *count) {
    uint64_t stored;
    if ((size_t)(end - p) < sizeof(double) + sizeof stored)
        return NULL;
    memcpy(&stored, p + sizeof(double), sizeof stored);
    p += sizeof(double) + sizeof stored;
    if (stored > (size_t)(end - p) / sizeof(Change))
        return NULL;
    *count = (size_t)stored;
    return p + *count * sizeof(Change);
}

/* Read a line that is whole; returns 0 if there is no memory for it. */
static int read_line(const unsigned char *p, size_t count, DelayLine *line) {
    if (!delay_reserve(line, count))
        return 0;
    memcpy(&line->value, p, sizeof(double));
    line->first = 0;
    line->count = count;
    if (count)
        memcpy(line->changes, p + sizeof(double) + sizeof(uint64_t),
               count * sizeof(Change));
    return 1;
}

/* Tell whether bytes are a whole snapshot of this model; if they were written,
   they may be foreign or damaged, and a damaged tick would never end. */
static int is_ours(const Component *c, const void *bytes, size_t size, int written) {
    Head head, expected = head_of(c, size);
    if (size < size_fixed())
        return 0;
    if (written)
        expected.digest =
            digest_of((const unsigned char *)bytes + sizeof(Head), size - sizeof(Head));
    memcpy(&head, bytes, sizeof head);
    if (memcmp(&head, &expected, sizeof head) != 0)
        return 0;
    const unsigned char *p = (const unsigned char *)bytes, *end = p + size;
    p += size_fixed();
    for (unsigned i = 0; p && i < M.n_delays; i++) {
        size_t count;
        p = line_end(p, end, &count);
    }
    return p == end;
}

static int refuse_foreign(Component *c, const char *function) {
    return component_refuse(c, "%s: this is no state of %s with token %.40s%s",
                            function, M.identifier, M.token,
                            c->model_exchange ? " for model exchange"
                                              : " for co-simulation");
}

int snapshot_restore(Component *c, const char *function, const void *snapshot) {
    if (!component_may(c, function, ANY))
        return STATUS_ERROR;
    if (!snapshot || !is_ours(c, snapshot, snapshot_bytes(snapshot), 0))
        return refuse_foreign(c, function);
    const unsigned char *p = (const unsigned char *)snapshot, *next;
    const unsigned char *end = p + snapshot_bytes(snapshot);
    p += sizeof(Head);
    memcpy(&c->simulation.state, p, sizeof(State));
    memcpy(c->simulation.values, p + sizeof(State), simulation_values());
    p += sizeof(State) + simulation_values();
    for (unsigned i = 0; i < M.n_delays; i++) {
        size_t count = 0;
        next = line_end(p, end, &count);
        if (!read_line(p, count, c->simulation.lines + i)) {
            c->simulation.state.phase = FAILED;
            return component_refuse(c, "%s: there is no memory for a delayed input",
                                    function);
        }
        p = next;
    }
    return STATUS_OK;
}

int snapshot_release(Component *c, const char *function, void **snapshot) {
    if (!component_may(c, function, ANY))
        return STATUS_ERROR;
    if (snapshot) {
        memory_release(*snapshot);
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
    *size = snapshot_bytes(snapshot);
    return STATUS_OK;
}

int snapshot_write(Component *c, const char *function, const void *snapshot,
                   unsigned char *bytes, size_t size) {
    if (!component_may(c, function, ANY))
        return STATUS_ERROR;
    if (!snapshot || !bytes || size != snapshot_bytes(snapshot))
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
    unsigned char *copy = renewed(snapshot, size);
    if (!copy)
        return component_refuse(c, "%s: there is no memory for the state", function);
    Head head = head_of(c, size);
    memcpy(copy, bytes, size);
    memcpy(copy, &head, sizeof head);
    return STATUS_OK;
}
