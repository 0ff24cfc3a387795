#include "memory.h"

#include "model.h"

#include <stdlib.h>
#include <string.h>

#ifdef FEEDDRIVE_INSTANCES

static int taken[FEEDDRIVE_INSTANCES];

static void *place(int i) {
    return feeddrive_pool + (size_t)i * feeddrive_place;
}

void *memory_take(size_t size) {
    int i = 0;
    while (i < FEEDDRIVE_INSTANCES && taken[i])
        i++;
    if (i == FEEDDRIVE_INSTANCES || size > feeddrive_place * sizeof(double))
        return NULL;
    taken[i] = 1;
    return memset(place(i), 0, size);
}

void memory_give(void *instance) {
    int i;
    for (i = 0; i < FEEDDRIVE_INSTANCES; i++)
        if (place(i) == instance)
            taken[i] = 0;
}

void *memory_more(size_t size) {
    (void)size;
    return NULL;
}

void memory_release(void *memory) {
    (void)memory;
}

#else

void *memory_take(size_t size) {
    return calloc(1, size);
}

void memory_give(void *instance) {
    free(instance);
}

void *memory_more(size_t size) {
    return malloc(size);
}

void memory_release(void *memory) {
    free(memory);
}

#endif
