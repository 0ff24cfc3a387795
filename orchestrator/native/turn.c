/* Waiting for a turn: spin, then yield, then sleep.

   With a core for each process spinning is quickest (0.25 us per turn and back).
   Where processes that wait share a core it delays the one that is waited for;
   yielding lets that one run (2 to 3 us).  But where others compute on that core a
   yield gives them a whole time slice (1000 us and more), and only sleeping until
   the system wakes us keeps turns short (3 to 100 us).  So each means is left out
   for a while when it failed: twice as long each time, shorter when it worked. */

#define _GNU_SOURCE /* nanosleep, sched_yield, syscall */

#include "turn.h"

#include <errno.h>

#ifdef _WIN32
#include <windows.h>
#else
#include <sched.h>
#include <time.h>
#endif
#ifdef __linux__
#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

static const int SPINS = 64;            /* about 2 us */
static const double YIELDING = 1e-4;    /* s in all */
static const double TIME_SLICE = 5e-4;  /* s: a yield this long went to others */
static const int LONGEST_REST = 1 << 12; /* waits */

double kernel_now(void);

uint32_t turn_number(const Turn *turn) {
    return __atomic_load_n(&turn->number, __ATOMIC_ACQUIRE);
}

static int wanted(Habit *habit) {
    if (!habit->rest)
        return 1;
    habit->rest--;
    return 0;
}

static void worked(Habit *habit) {
    if (habit->next_rest)
        habit->next_rest--;
}

static void failed(Habit *habit) {
    int32_t longer = habit->next_rest ? 2 * habit->next_rest : 4;
    habit->rest = habit->next_rest = longer < LONGEST_REST ? longer : LONGEST_REST;
}

static void relax(void) {
#if defined __x86_64__
    __builtin_ia32_pause();
#elif defined __aarch64__
    __asm__ volatile("yield");
#endif
}

static void yield(void) {
#ifdef _WIN32
    SwitchToThread();
#else
    sched_yield();
#endif
}

#ifdef __linux__
static int sleep_until_set(Turn *turn, uint32_t known) {
    const struct timespec longest = {0, 10000000};
    long how = 0;
    __atomic_store_n(&turn->slept_on, 1, __ATOMIC_SEQ_CST);
    if (__atomic_load_n(&turn->number, __ATOMIC_SEQ_CST) == known)
        how = syscall(SYS_futex, &turn->number, FUTEX_WAIT, known, &longest, NULL, 0);
    int signalled = how != 0 && errno == EINTR;
    __atomic_store_n(&turn->slept_on, 0, __ATOMIC_RELAXED);
    return signalled;
}

static void wake(Turn *turn) {
    syscall(SYS_futex, &turn->number, FUTEX_WAKE, 1, NULL, NULL, 0);
}
#else /* nobody wakes us: look again soon */
static int sleep_until_set(Turn *turn, uint32_t known) {
    (void)turn, (void)known;
#ifdef _WIN32
    Sleep(1);
    return 0;
#else
    const struct timespec a_little = {0, 100000};
    return nanosleep(&a_little, NULL) != 0 && errno == EINTR;
#endif
}

static void wake(Turn *turn) {
    (void)turn;
}
#endif

void turn_set(Turn *turn, uint32_t number) {
    __atomic_store_n(&turn->number, number, __ATOMIC_SEQ_CST);
    if (__atomic_load_n(&turn->slept_on, __ATOMIC_SEQ_CST))
        wake(turn);
}

static int spin(const Turn *turn, uint32_t known, Habit *habit) {
    for (int i = 0; i < SPINS; i++) {
        if (turn_number(turn) != known) {
            worked(habit);
            return 1;
        }
        relax();
    }
    failed(habit);
    return 0;
}

static int yield_until_set(const Turn *turn, uint32_t known, Habit *habit) {
    double begun = kernel_now(), before = begun;
    while (before - begun < YIELDING) {
        yield();
        double after = kernel_now();
        int lost = after - before > TIME_SLICE;
        if (lost)
            failed(habit);
        if (turn_number(turn) != known) {
            if (!lost)
                worked(habit);
            return 1;
        }
        if (lost)
            return 0;
        before = after;
    }
    return 0;
}

int turn_wait(Turn *turn, uint32_t known, Habits *habits) {
    if (turn_number(turn) != known)
        return CHANGED;
    if (wanted(&habits->spinning) && spin(turn, known, &habits->spinning))
        return CHANGED;
    if (wanted(&habits->yielding) && yield_until_set(turn, known, &habits->yielding))
        return CHANGED;
    int signalled = sleep_until_set(turn, known);
    if (turn_number(turn) != known)
        return CHANGED;
    return signalled ? SIGNALLED : UNCHANGED;
}
