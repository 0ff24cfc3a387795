/* Where instances live: on the heap, or, with FEEDDRIVE_INSTANCES=n, in a static
   pool of n places and nowhere else.  Nothing is taken while stepping. */
#ifndef MEMORY_H
#define MEMORY_H

#include "names.h"

#include <stddef.h>

/* Zeroed memory for one instance, or NULL if there is none. */
void *memory_take(size_t size);
void memory_give(void *instance);

/* Further memory, which a pool does not have (NULL). */
void *memory_more(size_t size);
void memory_release(void *memory);

#endif
