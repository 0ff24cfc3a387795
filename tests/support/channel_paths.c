/* Every way through channel.c and turn.c: what the clock says, whether a yield or a sleep
   comes back, what an operation on the FMU returns and when the other process sets its
   number are all told here, so that nothing depends on who is quicker.  Linux. */
#include <stdint.h>
#include <stdio.h>
#include <string.h>

static void seen(void); /* a number was read that two processes share */
#define __atomic_load_n(place, order) (seen(), *(place))
#define sched_yield told_yield
#define syscall told_syscall
#include "../../orchestrator/native/turn.c"
#include "../../orchestrator/native/channel.c"

static int wrong;

#define wanted(condition)                                                      \
    do {                                                                       \
        if (!(condition)) {                                                    \
            fprintf(stderr, "line %d: not so: %s\n", __LINE__, #condition);    \
            wrong = 1;                                                         \
        }                                                                      \
    } while (0)

static double now, every; /* s: between two readings of the clock */
static int reads, sets_at, sleeps, error_of_sleep;
static uint32_t *place, number;
static int succeeds[16], asked[16], n_asked; /* of the operations READ, WRITE, STEP */

double kernel_now(void) {
    return now += every;
}
static void seen(void) {
    if (++reads == sets_at)
        *place = number;
}
int told_yield(void) {
    return 0;
}
long told_syscall(long what, ...) {
    (void)what;
    sleeps++;
    errno = error_of_sleep;
    return error_of_sleep ? -1 : 0;
}

static Channel channel;
static double values[2];
static Link ours;
static int leaves; /* when it was read, it is asked to leave */

/* From now on the n-th reading finds another number there. */
static void at(int n, uint32_t *where, uint32_t what) {
    reads = 0;
    sets_at = n;
    place = where;
    number = what;
}

int kernel_one(void *kernel, int32_t code, double t, double h) {
    (void)kernel, (void)t, (void)h;
    asked[n_asked++ % 16] = code;
    if (leaves && code == READING) {
        channel.what = LEAVE;
        at(200, &channel.asked.number, channel.asked.number + 1);
    }
    return succeeds[code];
}

static void of_turns(void) {
    Turn turn = {0};
    Habits habits = {{0, 0}, {0, 0}};
    Habit *spinning = &habits.spinning, *yielding = &habits.yielding;
    every = 1e-6;
    at(0, NULL, 0);
    wanted(turn_wait(&turn, 1, &habits) == CHANGED);
    at(2, &turn.number, 1);
    wanted(turn_wait(&turn, 0, &habits) == CHANGED && !spinning->next_rest);
    turn.number = 0;
    at(SPINS + 3, &turn.number, 1); /* while it yields */
    wanted(turn_wait(&turn, 0, &habits) == CHANGED && spinning->rest == 4);
    wanted(!sleeps && !yielding->next_rest);
    turn.number = 0;
    at(0, NULL, 0);
    wanted(turn_wait(&turn, 0, &habits) == UNCHANGED && sleeps == 1);
    wanted(spinning->rest == 3 && !yielding->next_rest); /* it took no time slice */
    error_of_sleep = EINTR;
    wanted(turn_wait(&turn, 0, &habits) == SIGNALLED);
    error_of_sleep = EAGAIN;
    wanted(turn_wait(&turn, 0, &habits) == UNCHANGED);
    error_of_sleep = 0;
    every = 1e-3; /* a yield takes a time slice */
    wanted(turn_wait(&turn, 0, &habits) == UNCHANGED && yielding->rest == 4);
    *yielding = (Habit){0, 4};
    spinning->rest = 1;
    at(2, &turn.number, 1);
    wanted(turn_wait(&turn, 0, &habits) == CHANGED && yielding->next_rest == 8);
    turn.number = 0;
    every = 1e-6;
    *yielding = (Habit){0, 4};
    spinning->rest = 1;
    at(2, &turn.number, 1);
    wanted(turn_wait(&turn, 0, &habits) == CHANGED && yielding->next_rest == 3);
    turn.number = 0;
    *yielding = *spinning = (Habit){1, LONGEST_REST}; /* asleep when it is set */
    at(3, &turn.number, 1);
    wanted(turn_wait(&turn, 0, &habits) == CHANGED);
    turn.number = 0;
    *yielding = (Habit){1, 0};
    *spinning = (Habit){0, LONGEST_REST};
    at(0, NULL, 0);
    wanted(turn_wait(&turn, 0, &habits) == UNCHANGED);
    wanted(spinning->next_rest == LONGEST_REST);
    at(1, &turn.number, 1); /* set just before it would sleep */
    sleeps = 0;
    wanted(!sleep_until_set(&turn, 0) && !sleeps);
    turn_set(&turn, 5);
    wanted(turn.number == 5 && !sleeps);
    turn.slept_on = 1;
    turn_set(&turn, 6);
    wanted(turn.number == 6 && sleeps == 1);
}


static void anew(void) {
    memset(&channel, 0, sizeof channel);
    ours = (Link){.channel = &channel, .values = values, .n_inputs = 1, .n_outputs = 1,
                  .within = 1};
    at(0, NULL, 0);
    every = 1e-6;
    error_of_sleep = 0;
    for (int i = 0; i < 16; i++)
        succeeds[i] = 1;
    n_asked = 0;
}

static void of_who_asks(void) {
    double u = 3, y = 0;
    anew();
    every = 0.3;
    wanted(channel_step(&ours, 0.5, 0.25, 1) == LATE);
    wanted(channel.asked.number == 1 && channel.steps == 1 && channel.t == 0.5);
    anew();
    ours.ended = 1;
    wanted(channel_ask(&ours, LEAVE) == ENDED);
    anew();
    error_of_sleep = EINTR;
    wanted(channel_ask(&ours, EXCHANGE) == INTERRUPTED);
    anew();
    at(1000, &channel.answered.number, 1); /* after some sleeps */
    wanted(channel_ask(&ours, EXCHANGE) == OK);
    anew();
    channel.failed = 1;
    at(3, &channel.answered.number, 1);
    wanted(channel_ask(&ours, EXCHANGE) == REFUSED);
    anew();
    values[1] = 7;
    wanted(channel_get(&ours, NULL, 0, &y) == OK && y == 7 && !channel.asked.number);
    wanted(channel_set(&ours, NULL, 0, &u) == OK && values[0] == 3 && channel.given);
    at(3, &channel.answered.number, 1);
    wanted(channel_get(&ours, NULL, 0, &y) == OK && channel.asked.number == 1);
    wanted(channel.what == EXCHANGE && !ours.stale);
}

/* What is served until a request to leave, or one that failed. */
static int served(int what, int given, int32_t *doing) {
    n_asked = 0;
    channel.what = what;
    channel.given = given;
    channel.asked.number = channel.answered.number;
    at(200, &channel.asked.number, channel.answered.number + 1);
    int how = channel_serve(&channel, NULL);
    *doing = channel.doing;
    return how;
}

static void of_who_serves(void) {
    static const struct {
        int code, what, given, calls;
    } failing[] = {{WRITING, STEP, 1, 1}, {STEPPING, STEP, 1, 2}, {STEPPING, STEP, 0, 1},
                   {READING, STEP, 1, 3}, {READING, EXCHANGE, 0, 1},
                   {WRITING, EXCHANGE, 1, 1}};
    int32_t doing;
    anew();
    wanted(served(LEAVE, 0, &doing) == 1 && n_asked == 0 && doing == SET);
    wanted(channel.answered.number == 1);
    for (size_t i = 0; i < sizeof failing / sizeof *failing; i++) {
        anew();
        succeeds[failing[i].code] = 0;
        wanted(served(failing[i].what, failing[i].given, &doing) == 0);
        wanted(n_asked == failing[i].calls && doing == NOTHING && !channel.given);
        wanted(asked[n_asked - 1] == failing[i].code && channel.answered.number == 0);
        channel_answer(&channel);
        wanted(channel.failed && channel.answered.number == channel.asked.number);
    }
    anew();
    leaves = 1;
    wanted(served(STEP, 1, &doing) == 1 && n_asked == 3);
    wanted(channel.answered.number == 2 && !channel.failed);
}

int main(void) {
    of_turns();
    of_who_asks();
    of_who_serves();
    if (!wrong)
        printf("every way\n");
    return wrong;
}
