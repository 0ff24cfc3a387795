/* The rows of a table, one a tick, read from resources/table.bin: doubles, rows
   first, little end first.  All instances of a library share them. */
#include "model.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FILE_NAME "table.bin"

static double *table;

#if defined(__GNUC__)
__attribute__((destructor)) static void forget(void) {
    free(table);
    table = NULL;
}
#endif

static int hexadecimal(char c) {
    return c >= '0' && c <= '9'   ? c - '0'
           : c >= 'a' && c <= 'f' ? c - 'a' + 10
           : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                  : -1;
}

/* The path of the file in a folder, which FMI 2 writes as a URI; NULL without memory. */
static char *path_of(const char *folder) {
    char *path = (char *)malloc(strlen(folder) + sizeof FILE_NAME + 1), *to = path;
    const char *from = folder;
    int uri = strncmp(folder, "file:", 5) == 0;
    if (!path)
        return NULL;
    if (uri) {
        from += 5;
        if (strncmp(from, "//", 2) == 0) {
            from += 2;
            while (*from && *from != '/')
                from++; /* a host */
        }
        if (from[0] == '/' && from[1] && from[2] == ':')
            from++; /* C: */
    }
    while (*from) {
        int high = uri && *from == '%' ? hexadecimal(from[1]) : -1;
        int low = high >= 0 ? hexadecimal(from[2]) : -1;
        *to++ = low >= 0 ? (char)(16 * high + low) : *from;
        from += low >= 0 ? 3 : 1;
    }
    if (to > path && to[-1] != '/' && to[-1] != '\\')
        *to++ = '/';
    strcpy(to, FILE_NAME);
    return path;
}

static const char *read_whole(FILE *file, double *rows) {
    size_t n = (size_t)ROWS * COLUMNS;
    if (fread(rows, sizeof *rows, n, file) != n || fgetc(file) != EOF)
        return "resources/table.bin is not that of this FMU; take the whole archive";
    return NULL;
}

/* Keep the rows that are read first; another thread may be as far. */
static void keep(double *rows) {
#if defined(__GNUC__)
    double *none = NULL;
    if (!__atomic_compare_exchange_n(&table, &none, rows, 0, __ATOMIC_SEQ_CST,
                                     __ATOMIC_SEQ_CST))
        free(rows);
#else
    if (table)
        free(rows);
    else
        table = rows;
#endif
}

static const char *written_open(const char *resources) {
    const char *why = "resources/table.bin cannot be opened; give the folder resources "
                      "of the unpacked archive";
    char *path;
    double *rows;
    FILE *file;
    if (table)
        return NULL;
    if (!resources)
        return why;
    path = path_of(resources);
    file = path ? fopen(path, "rb") : NULL;
    free(path);
    if (!file)
        return why;
    rows = (double *)malloc((size_t)ROWS * COLUMNS * sizeof *rows);
    why = rows ? read_whole(file, rows) : "there is no memory for its table";
    fclose(file);
    if (why)
        free(rows);
    else
        keep(rows);
    return why;
}

static int written_prepare(const double **arg, double **res, long long *iw, double *w, int mem) {
    (void)arg, (void)res, (void)iw, (void)w, (void)mem;
    return 0;
}

/* Row k, or the first or last one beyond; the next state is k + 1. */
static int written_step(const double **arg, double **res, long long *iw, double *w, int mem) {
    double k = arg[0][0];
    size_t row = k >= ROWS - 1 ? ROWS - 1 : k > 0 ? (size_t)k : 0;
    (void)iw, (void)w, (void)mem;
    memcpy(res[1], table + row * COLUMNS, COLUMNS * sizeof *table);
    res[0][0] = k + 1;
    return 0;
}
