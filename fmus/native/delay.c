#include "delay.h"

#include "memory.h"

void delay_reset(DelayLine *line, double value) {
    line->value = value;
    line->first = line->count = 0;
}

int delay_reserve(DelayLine *line, size_t capacity) {
    Change *room;
    size_t i;
    if (capacity <= line->capacity)
        return 1;
    room = (Change *)memory_more(capacity * sizeof(Change));
    if (!room)
        return 0;
    for (i = 0; i < line->count; i++)
        room[i] = *delay_next(line, i);
    memory_release(line->grown);
    line->changes = line->grown = room;
    line->first = 0;
    line->capacity = capacity;
    return 1;
}

int delay_enter(DelayLine *line, double time, double value) {
    Change *change;
    double last = line->count ? delay_next(line, line->count - 1)->value : line->value;
    if (value == last)
        return 1;
    if (line->count == line->capacity)
        return 0;
    change = line->changes + (line->first + line->count++) % line->capacity;
    change->time = time;
    change->value = value;
    return 1;
}

const Change *delay_next(const DelayLine *line, size_t n) {
    if (n >= line->count)
        return NULL;
    return line->changes + (line->first + n) % line->capacity;
}

void delay_arrive(DelayLine *line) {
    line->value = line->changes[line->first].value;
    line->first = (line->first + 1) % line->capacity;
    line->count--;
}

void delay_free(DelayLine *line) {
    memory_release(line->grown);
}
