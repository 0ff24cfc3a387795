/* The files of a Python FMU: its resources folder, and pythonfmu's library that
   stands beside ours. */
#define _GNU_SOURCE
#include "python_gate_files.h"
#include "token.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
#else
#include <dlfcn.h>
#endif

#define SCHEME "file://"
#ifdef _WIN32
#define ROOT sizeof SCHEME /* file:///C:/ */
#else
#define ROOT (sizeof SCHEME - 1)
#endif

static int hex(char digit) {
    static const char digits[] = "0123456789abcdef0123456789ABCDEF";
    const char *found = digit ? strchr(digits, digit) : NULL;
    return found ? (int)((found - digits) % 16) : -1;
}

char *plain_uri(const char *uri) {
    if (!uri || strncmp(uri, "file:/", 6) != 0)
        return NULL;
    const char *from = uri + 5;
    if (strncmp(from, "//localhost/", 12) == 0)
        from += 11;
    else if (strncmp(from, "///", 3) == 0)
        from += 2;
    else if (from[1] == '/')
        return NULL;
    char *plain = malloc(strlen(from) + sizeof SCHEME), *to = plain;
    if (!plain)
        return NULL;
    to += sprintf(to, SCHEME);
    for (; *from; from++) {
        if (*from == '%' && hex(from[1]) >= 0 && hex(from[2]) >= 0) {
            *to++ = (char)(16 * hex(from[1]) + hex(from[2]));
            from += 2;
        } else {
            *to++ = *from;
        }
    }
    *to = '\0';
    return plain;
}

int holds_slave(const char *uri) {
    static const char file[] = "/slavemodule.txt";
    char *path = malloc(strlen(uri) + sizeof file);
    if (!path)
        return 0;
    sprintf(path, "%s%s", uri + ROOT, file);
    FILE *opened = fopen(path, "rb");
    free(path);
    if (opened)
        fclose(opened);
    return opened != NULL;
}

#ifdef _WIN32
void *open_beside(char *problem, size_t size) {
    wchar_t path[32768];
    HMODULE self;
    DWORD how = GET_MODULE_HANDLE_EX_FLAG_FROM_ADDRESS |
                GET_MODULE_HANDLE_EX_FLAG_UNCHANGED_REFCOUNT;
    if (GetModuleHandleExW(how, (LPCWSTR)(void *)open_beside, &self)) {
        DWORD length = GetModuleFileNameW(self, path, 32768);
        while (length && path[length - 1] != L'\\')
            length--;
        if (length + sizeof LIBRARY <= 32768) {
            for (size_t i = 0; i < sizeof LIBRARY; i++)
                path[length + i] = (wchar_t)LIBRARY[i];
            HMODULE library =
                LoadLibraryExW(path, NULL, LOAD_WITH_ALTERED_SEARCH_PATH);
            if (library)
                return library;
        }
    }
    snprintf(problem, size, "%s: Windows error %lu", LIBRARY, GetLastError());
    return NULL;
}

void *symbol(void *library, const char *name) {
    return (void *)GetProcAddress(library, name);
}

void close_library(void *library) {
    FreeLibrary(library);
}
#else
void *open_beside(char *problem, size_t size) {
    Dl_info self;
    void *library = NULL;
    if (dladdr(LIBRARY, &self) && self.dli_fname) {
        const char *slash = strrchr(self.dli_fname, '/');
        size_t folder = slash ? (size_t)(slash - self.dli_fname) + 1 : 0;
        char *path = malloc(folder + sizeof LIBRARY);
        if (path) {
            memcpy(path, self.dli_fname, folder);
            memcpy(path + folder, LIBRARY, sizeof LIBRARY);
            library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
            free(path);
        }
    }
    const char *said = library ? NULL : dlerror();
    if (!library)
        snprintf(problem, size, "%s", said ? said : LIBRARY);
    return library;
}

void *symbol(void *library, const char *name) {
    return dlsym(library, name);
}

void close_library(void *library) {
    dlclose(library);
}
#endif
