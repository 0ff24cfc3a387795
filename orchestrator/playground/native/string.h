/* Of the compiler's own library. */
#ifndef PLAYED_STRING_H
#define PLAYED_STRING_H

#include <stddef.h>

void *memcpy(void *to, const void *from, size_t n);
void *memmove(void *to, const void *from, size_t n);
void *memset(void *to, int value, size_t n);

#endif
