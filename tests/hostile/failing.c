/* Preloaded, it fails the n-th of the calls open, read, write, rename, fsync, mmap on
   files below given folders, and of fork, in all processes together.

   FAILING_BELOW   folders, separated by ':'
   FAILING_COUNT   file with the number of calls so far, shared by all processes
   FAILING_AT      n, or 0 to count only
   FAILING_TOLD    file that takes the name of the call that failed
   FAILING_POWER   file; then the n-th call is where power fails: all processes of the
                   group are killed, and the file has what was done to files until then:
                   "w size path" opened to write, of that size; "t 0 path" made or cut;
                   "s size path" synced; "r 0 path" renamed to the path of the next
                   line; "n 0 path" the new name; "d 0 path" a folder synced */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <limits.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static volatile int64_t *count; /* NULL: nothing is counted */
static int64_t at;
static const char *below;

/* Begin to count, as the environment says; a process that was forked calls it again. */
__attribute__((constructor)) void failing_begin(void) {
    const char *file = getenv("FAILING_COUNT"), *n = getenv("FAILING_AT");
    below = getenv("FAILING_BELOW");
    if (!file || !n || !below)
        return;
    int d = REAL(open)(file, O_RDWR);
    void *place = REAL(mmap)(NULL, 8, PROT_READ | PROT_WRITE, MAP_SHARED, d, 0);
    close(d);
    at = atoll(n);
    count = place == MAP_FAILED ? NULL : place;
}

static int is_below(const char *path) {
    for (const char *folder = below; folder && *folder;) {
        size_t size = strcspn(folder, ":");
        if (!strncmp(path, folder, size) && (path[size] == '/' || !path[size]))
            return 1;
        folder += size + (folder[size] == ':');
    }
    return 0;
}

/* Tell whether this call is the one that fails. */
static int fails(const char *call, const char *path) {
    if (!count || __atomic_add_fetch(count, 1, __ATOMIC_SEQ_CST) != at)
        return 0;
    if (getenv("FAILING_POWER"))
        kill(0, SIGKILL);
    const char *file = getenv("FAILING_TOLD");
    int d = file ? REAL(open)(file, O_WRONLY | O_CREAT | O_APPEND, 0600) : -1;
    char line[PATH_MAX + 32];
    int size = snprintf(line, sizeof line, "%s %s\n", call, path);
    if (d >= 0 && REAL(write)(d, line, (size_t)size) < 0)
        errno = 0;
    close(d);
    return 1;
}

/* Write down what was done to files, in one write per line. */
static void note(char what, int64_t size, const char *path) {
    const char *file = getenv("FAILING_POWER");
    char line[PATH_MAX + 32];
    if (!count || !file || !is_below(path))
        return;
    int d = REAL(open)(file, O_WRONLY | O_CREAT | O_APPEND, 0600), kept = errno;
    int n = snprintf(line, sizeof line, "%c %lld %s\n", what, (long long)size, path);
    if (d >= 0 && REAL(write)(d, line, (size_t)n) < 0)
        kept = errno;
    close(d);
    errno = kept;
}

static void note_descriptor(char what, int d) {
    char path[PATH_MAX], link[64];
    struct stat about;
    if (!count || d < 0 || fstat(d, &about))
        return;
    snprintf(link, sizeof link, "/proc/self/fd/%d", d);
    ssize_t n = readlink(link, path, sizeof path - 1);
    if (n < 0)
        return;
    path[n] = 0;
    if (what == 's' && S_ISDIR(about.st_mode))
        what = 'd';
    note(what, about.st_size, path);
}

/* A file that was opened, when it may be written to. */
static int noted(int flags, int d) {
    int kept = errno;
    if (flags & (O_WRONLY | O_RDWR))
        note_descriptor(flags & (O_TRUNC | O_EXCL) ? 't' : 'w', d);
    errno = kept;
    return d;
}

/* Put the whole path into a buffer of PATH_MAX; returns 0 if there is none. */
static int absolute(int folder, const char *path, char *whole) {
    char here[PATH_MAX] = "", link[64];
    if (*path != '/') {
        if (folder == AT_FDCWD) {
            if (!getcwd(here, sizeof here))
                return 0;
        } else {
            snprintf(link, sizeof link, "/proc/self/fd/%d", folder);
            ssize_t size = readlink(link, here, sizeof here - 1);
            here[size < 0 ? 0 : size] = 0;
        }
    }
    return snprintf(whole, PATH_MAX, "%s%s%s", here, *here ? "/" : "", path) > 0;
}

static int path_fails(const char *call, int folder, const char *path) {
    char whole[PATH_MAX];
    if (!count || !path || !absolute(folder, path, whole))
        return 0;
    return is_below(whole) && fails(call, whole);
}

static void note_path(char what, const char *path) {
    char whole[PATH_MAX];
    if (count && absolute(AT_FDCWD, path, whole))
        note(what, 0, whole);
}

static int descriptor_fails(const char *call, int d) {
    char path[PATH_MAX], link[64];
    if (!count || d < 3)
        return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", d);
    ssize_t size = readlink(link, path, sizeof path - 1);
    if (size < 0)
        return 0;
    path[size] = 0;
    return is_below(path) && fails(call, path);
}

#define FAIL(number) return errno = number, -1
#define MODE \
    mode_t mode = 0; \
    if (flags & (O_CREAT | O_TMPFILE)) { \
        va_list more; \
        va_start(more, flags); \
        mode = va_arg(more, mode_t); \
        va_end(more); \
    }

int open(const char *path, int flags, ...) {
    MODE
    if (path_fails("open", AT_FDCWD, path))
        FAIL(EMFILE);
    return noted(flags, REAL(open)(path, flags, mode));
}
int open64(const char *path, int flags, ...) {
    MODE
    if (path_fails("open", AT_FDCWD, path))
        FAIL(EMFILE);
    return noted(flags, REAL(open64)(path, flags, mode));
}
int openat(int folder, const char *path, int flags, ...) {
    MODE
    if (path_fails("open", folder, path))
        FAIL(EMFILE);
    return noted(flags, REAL(openat)(folder, path, flags, mode));
}
int openat64(int folder, const char *path, int flags, ...) {
    MODE
    if (path_fails("open", folder, path))
        FAIL(EMFILE);
    return noted(flags, REAL(openat64)(folder, path, flags, mode));
}
ssize_t read(int d, void *to, size_t size) {
    if (descriptor_fails("read", d))
        FAIL(EIO);
    return REAL(read)(d, to, size);
}
ssize_t pread64(int d, void *to, size_t size, off64_t from) {
    if (descriptor_fails("read", d))
        FAIL(EIO);
    return REAL(pread64)(d, to, size, from);
}
ssize_t write(int d, const void *from, size_t size) {
    if (descriptor_fails("write", d))
        FAIL(ENOSPC);
    return REAL(write)(d, from, size);
}
int rename(const char *from, const char *to) {
    if (path_fails("rename", AT_FDCWD, to))
        FAIL(EIO);
    int done = REAL(rename)(from, to);
    if (!done) {
        note_path('r', from);
        note_path('n', to);
    }
    return done;
}
int renameat(int a, const char *from, int b, const char *to) {
    if (path_fails("rename", b, to))
        FAIL(EIO);
    return REAL(renameat)(a, from, b, to);
}
int fsync(int d) {
    if (descriptor_fails("fsync", d))
        FAIL(EIO);
    int done = REAL(fsync)(d);
    if (!done)
        note_descriptor('s', d);
    return done;
}
void *mmap(void *place, size_t size, int how, int flags, int d, off_t from) {
    if (d >= 0 && descriptor_fails("mmap", d))
        return errno = ENOMEM, MAP_FAILED;
    return REAL(mmap)(place, size, how, flags, d, from);
}
void *mmap64(void *place, size_t size, int how, int flags, int d, off64_t from) {
    if (d >= 0 && descriptor_fails("mmap", d))
        return errno = ENOMEM, MAP_FAILED;
    return REAL(mmap64)(place, size, how, flags, d, from);
}
pid_t fork(void) {
    if (fails("fork", ""))
        FAIL(EAGAIN);
    return REAL(fork)();
}
