/* An FMI 2.0 co-simulation FMU that attacks its host in the way HOW says, in its third
   step or later; config.h as for foreign.c.  Until then y = u + t. */
#pragma GCC diagnostic ignored "-Wunused-parameter"
#define _GNU_SOURCE
#include "config.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <signal.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#define EXPORT __attribute__((visibility("default")))
#define DESCRIPTORS 256
#define TEXT_(x) #x
#define TEXT(x) TEXT_(x)

enum { OK, WARNS, DISCARD, ERROR };
enum {
    WELL, WRITES, CLOSES, CUTS, DAEMON, CONSTRUCTOR, CRASH_IN_TERMINATE, CRASH_IN_FREE,
    HANG_IN_TERMINATE, BEYOND, BEFORE, STOPS, UNMARKED, FORGES, HANG, EXIT_0,
    EXIT_0_IN_CONSTRUCTOR, HANG_IN_FREE, CRASH, ABORTS, NOT_A_NUMBER, RETURNS_ERROR,
    LOGS, ESCAPES
};

typedef void Logger(void *, const char *, int, const char *, const char *, ...);

typedef struct {
    double real[3];
    int steps;
    Logger *log;
    char name[64];
} Instance;

static void crash(void) {
    *(volatile int *)8 = 1;
}

static void hang(void) {
    for (volatile int n = 0;; n++)
        ;
}

__attribute__((constructor)) static void loaded(void) {
    if (HOW == CONSTRUCTOR)
        hang();
    if (HOW == EXIT_0_IN_CONSTRUCTOR)
        exit(0);
}

/* Leave a process that has a session of its own and no parent. */
static void leave_daemon(void) {
    if (fork())
        return;
    setsid();
    if (fork())
        _exit(0);
    char *arguments[] = {"sleep", TEXT(SLEEP), NULL}, *nothing[] = {NULL};
    if (HOW == UNMARKED)
        execve("/bin/sleep", arguments, nothing);
    for (;;)
        pause();
}

static void *idle(void *nothing) { return nothing; }

/* Try what a sandbox denies, and what it allows; one bit for each that was done. */
static int escape(void) {
    char *arguments[] = {"true", NULL}, *nothing[] = {NULL}, own[4096];
    const char *outside = getenv("HOSTILE_FILE"), *folder = getenv("TMPDIR");
    pthread_t thread;
    int done = 0, d = -1;
    if (!outside || !folder)
        return -1;
    done |= (open(outside, O_RDONLY) >= 0) << 0;
    done |= (open(outside, O_WRONLY | O_APPEND) >= 0) << 1;
    done |= (socket(AF_INET, SOCK_STREAM, 0) >= 0) << 2;
    pid_t child = fork();
    if (!child)
        _exit(execve("/bin/true", arguments, nothing));
    done |= (child > 0) << 3;
    if (child < 0)
        execve("/bin/true", arguments, nothing);
    done |= (kill(getppid(), 0) == 0) << 4;
    done |= (chmod(outside, 0600) == 0) << 5;
    done |= (rename(outside, outside) == 0) << 6;
    errno = 0;
    ptrace(PTRACE_PEEKUSER, 1 << 30, NULL, NULL); /* nobody */
    done |= (errno == ESRCH) << 7;
    snprintf(own, sizeof own, "%s/own", folder);
    d = open(own, O_RDWR | O_CREAT, 0600);
    done |= (d >= 0 && unlink(own) == 0) << 8;
    if (pthread_create(&thread, NULL, idle, NULL) == 0)
        done |= (pthread_join(thread, NULL) == 0) << 9;
    return done;
}

static void attack(void) {
    static const char noise[64] = {0, 0, 0, 9, '[', '"', 'd'};
    static const char answer[] = "\0\0\0\x0e[\"done\", null]";
    for (int d = 3; d < DESCRIPTORS; d++) {
        if (HOW == WRITES && write(d, noise, sizeof noise) < 0)
            continue;
        for (int n = 0; HOW == FORGES && n < 20; n++)
            if (write(d, answer, sizeof answer - 1) < 0)
                break;
        if (HOW == CUTS && ftruncate(d, 0) < 0)
            continue;
        if (HOW == CLOSES)
            close(d);
    }
    if (HOW == DAEMON || HOW == UNMARKED)
        leave_daemon();
    if (HOW == STOPS)
        kill(getpid(), SIGSTOP);
    if (HOW == HANG)
        hang();
    if (HOW == EXIT_0)
        exit(0);
    if (HOW == CRASH)
        crash();
    if (HOW == ABORTS)
        abort();
}

EXPORT void *fmi2Instantiate(const char *name, int type, const char *guid,
                             const char *resources, const void *callbacks, int visible,
                             int logging) {
    Instance *i = calloc(1, sizeof *i);
    i->log = *(Logger *const *)callbacks;
    strncpy(i->name, name, sizeof i->name - 1);
    return i;
}

EXPORT void FREE(Instance *i) {
    if (HOW == CRASH_IN_FREE)
        crash();
    if (HOW == HANG_IN_FREE)
        hang();
    free(i);
}

EXPORT int TERMINATE(void *i) {
    if (HOW == CRASH_IN_TERMINATE)
        crash();
    if (HOW == HANG_IN_TERMINATE)
        hang();
    return OK;
}

EXPORT int fmi2SetupExperiment(void *i, int a, double b, double c, int d, double e) {
    return OK;
}
EXPORT int ENTER(void *i) { return OK; }
EXPORT int EXIT(void *i) { return OK; }

EXPORT int fmi2GetReal(Instance *i, const unsigned *r, size_t n, double *values) {
    for (size_t k = 0; k < n; k++)
        values[k] = i->real[r[k]];
    if (i->steps > 2 && (HOW == BEYOND || HOW == BEFORE))
        memset(HOW == BEYOND ? values + n : values - 600, 7, 4800);
    return OK;
}
EXPORT int fmi2SetReal(Instance *i, const unsigned *r, size_t n, const double *values) {
    for (size_t k = 0; k < n; k++)
        i->real[r[k]] = values[k];
    return OK;
}

EXPORT int fmi2DoStep(Instance *i, double t, double h, int no_set_state) {
    i->real[1] = i->real[0] + t + h;
    if (++i->steps != 3)
        return OK;
    attack();
    if (HOW == ESCAPES)
        i->real[1] = escape();
    if (HOW == NOT_A_NUMBER)
        i->real[1] = 0.0 / (t - t);
    if (HOW == LOGS) {
        i->log(NULL, i->name, WARNS, "evil", "\033]0;evil\a\033[2J");
        fputs("\033[2Jprinted\n", stderr);
    }
    return HOW == RETURNS_ERROR ? ERROR : OK;
}

ABSENT
