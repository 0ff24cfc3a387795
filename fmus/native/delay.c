#include "delay.h"

#include <stdlib.h>
#include <string.h>

void delay_reset(DelayLine *line, double value) {
    line->value = value;
    line->first = line->count = 0;
}

/* Make room for one more change behind the last. */
static int make_room(DelayLine *line) {
    if (line->first + line->count < line->capacity)
        return 1;
    if (line->first > line->capacity / 2) {
        memmove(line->changes, line->changes + line->first,
                line->count * sizeof(Change));
        line->first = 0;
        return 1;
    }
    size_t capacity = line->capacity ? 2 * line->capacity : 16;
    Change *changes = realloc(line->changes, capacity * sizeof(Change));
    if (!changes)
        return 0;
    line->changes = changes;
    line->capacity = capacity;
    return 1;
}

int delay_enter(DelayLine *line, double time, double value) {
    size_t end = line->first + line->count;
    double last = line->count ? line->changes[end - 1].value : line->value;
    if (value == last)
        return 1;
    if (!make_room(line))
        return 0;
    line->changes[line->first + line->count++] = (Change){time, value};
    return 1;
}

const Change *delay_next(const DelayLine *line) {
    return line->count ? line->changes + line->first : NULL;
}

void delay_arrive(DelayLine *line) {
    line->value = line->changes[line->first++].value;
    line->count--;
}

void delay_free(DelayLine *line) {
    free(line->changes);
}
