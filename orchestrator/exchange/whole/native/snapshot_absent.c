/* FMU states of a composition with FMUs of others inside: there are none. */
#include "component.h"

static int absent(Component *c, const char *function) {
    if (!component_may(c, function, ANY))
        return STATUS_ERROR;
    return component_refuse(c, "%s is not supported: FMUs of others are inside", function);
}

int snapshot_take(Component *c, const char *function, void **snapshot) {
    (void)snapshot;
    return absent(c, function);
}

int snapshot_restore(Component *c, const char *function, const void *snapshot) {
    (void)snapshot;
    return absent(c, function);
}

int snapshot_release(Component *c, const char *function, void **snapshot) {
    (void)snapshot;
    return absent(c, function);
}

int snapshot_size(Component *c, const char *function, const void *snapshot, size_t *size) {
    (void)snapshot, (void)size;
    return absent(c, function);
}

int snapshot_write(Component *c, const char *function, const void *snapshot,
                   unsigned char *bytes, size_t size) {
    (void)snapshot, (void)bytes, (void)size;
    return absent(c, function);
}

int snapshot_read(Component *c, const char *function, const unsigned char *bytes,
                  size_t size, void **snapshot) {
    (void)bytes, (void)size, (void)snapshot;
    return absent(c, function);
}
