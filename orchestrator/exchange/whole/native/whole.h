/* A composition as one model: what its generated loop offers to simulation.c.

   Values lie as model.h says: parameters, inputs, outputs, states of the parts by
   component.name, then one place per part and one for the initial circle, which
   turns NaN where one of these fails.  The loop's memory is a block of its own; no
   pointer in it is kept between calls, so that it can be copied as it is.

   An instant has two halves: continuous parts arrive at it and are read, then the
   sampled ones tick.  A half that is open is finished before anything later. */
#ifndef WHOLE_H
#define WHOLE_H

#include <stddef.h>
#include <stdint.h>

enum { WHOLE = 0, HALF = 1 }; /* how the last instant is carried out */

extern const int64_t whole_tick_num, whole_tick_den; /* s */

/* Doubles of the memory. */
size_t whole_size(void);

/* Bytes for the FMUs of others inside, zeroed memory that stays where it is and is
   handed over with every call; they are freed at last. */
size_t whole_loaded(void);
void whole_free(void *loaded);

/* Their states, where there are any inside: bytes to be freed, none of one that is not
   instantiated; 0 is returned if one refuses. */
unsigned whole_foreign(void);
int whole_save(const void *loaded, unsigned i, unsigned char **bytes, size_t *size);
int whole_load(void *loaded, unsigned i, const unsigned char *bytes, size_t size);

/* Initialise by the parameters, inputs and states among the values; then, and in what
   follows, 0 is returned if something fails. */
int whole_start(double *memory, const double *values, void *loaded);

/* Carry out what is due up to a tick, or only a half of what is due at it. */
int whole_run(double *memory, const double *values, void *loaded, int64_t tick, int last);

/* Finish an open half. */
int whole_finish(double *memory, const double *values, void *loaded);

/* Read outputs, and states unless they are to stay as they were set. */
void whole_read(const double *memory, double *values, int states);

/* What failed: a place as above, and when (s); or a delayed input. */
enum { WHOLE_FINE, WHOLE_NOT_FINITE, WHOLE_LINE_FULL };
int whole_failure(const double *memory, unsigned *place, double *t);

/* Whether a dead time (s) of delay i fits into its line. */
int whole_fits(unsigned i, double tau);

#endif
