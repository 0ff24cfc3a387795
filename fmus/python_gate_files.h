#ifndef PYTHON_GATE_FILES_H
#define PYTHON_GATE_FILES_H

#include <stddef.h>


/* The URI as pythonfmu reads it: file:///, nothing escaped; NULL for what is no file
   of this machine.  The caller frees it. */
char *plain_uri(const char *uri);

/* Whether the folder of a plain URI holds what pythonfmu reads first. */
int holds_slave(const char *uri);

/* Loads LIBRARY from the folder of this one; NULL, with the reason, if it cannot. */
void *open_beside(char *problem, size_t size);
void *symbol(void *library, const char *name);
void close_library(void *library);


#endif
