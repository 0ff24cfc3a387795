
/* s of the processor */
static double now(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int main(int n, char **arguments) {
    file = fopen(arguments[n - 1], "wb");
    start();
    double begun = now();
    int good = first(0);
    for (long long k = 1; good && k < N; k++)
        good = steady(k);
    good = good && last(N);
    double took = now() - begun;
    char text[4096] = "";
    FILE *status = fopen("/proc/self/status", "r");
    fread(text, 1, sizeof text - 1, status);
    char *found = strstr(text, "VmHWM:");
    printf("{\"seconds\": %.9g, \"steps\": %d, \"peak\": %ld, \"last\": [", took, N,
           found ? 1024 * atol(found + 6) : 0);
    for (int c = 0; c < COLUMNS; c++)
        printf("%s%.17g", c ? ", " : "", rows[c][filled - 1]);
    printf("]}\n");
    return !good;
}
