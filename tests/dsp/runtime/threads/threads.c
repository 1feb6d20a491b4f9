/* The threads that share memory with kernels, under ThreadSanitizer: what Python does beside them, in C.

   threads CASE [careless] [NUMBER ...]: the numbers are those of atomic operations that are to have no order. */
#include <pthread.h>
#include <sched.h>
#include <semaphore.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>
#include <unistd.h>

typedef int64_t word;

int order_of[64] = {ORDERS};

void take(void *), tap(void *), note(void *, word), report(void *, word), trace(void *, word);
int guarded(void *, void *, unsigned long, void *, unsigned long, void *);
void pace(void *, word, word, double, void *, word, word, void *);
void work(void *, void *, word, word, void *), finish(void *, void *, word, word, void *), drain(void *);
void publish_at(void *, word);
word _observe(void *), _confirm(void *), _swap(void *, word, word);

static char *state;
static int careless; /* does the wrong thing: publishes before it writes, or writes without a lock */

#define I(place) (*(word *)(state + (place)))
#define REQUIRE(holds) \
    do { \
        if (!(holds)) { \
            fprintf(stderr, "line %d: expected %s\n", __LINE__, #holds); \
            exit(1); \
        } \
    } while (0)

word carom_monotonic_ns(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return now.tv_sec * 1000000000ll + now.tv_nsec;
}

void carom_pause_ns(word time) {
    struct timespec pause = {0, time};
    nanosleep(&pause, NULL);
}

/* What is no part of the protocol isn't told, so that what is stays in ThreadSanitizer's history. */
#define UNTOLD __attribute__((no_sanitize("thread"), noinline))

static unsigned chance = 1;

static unsigned draw(unsigned below) {
    chance = chance * 1664525u + 1013904223u;
    return (chance >> 8) % below;
}

/* ---- The engine, in whichever thread a device calls it ---- */

static word taken, calls;        /* commands, and calls of the engine */
static int hangs, over;          /* a device hangs in the engine; all is over */

/* Take commands into a queue that is nearly full, and check what has come. */
enum { QUEUED = EVENTS - 64 };

UNTOLD static void check_events(void) {
    for (word n = QUEUED; n < I(Q_SIZE); n++) {
        char *event = state + Q_EVENTS + ((word *)(state + Q_HEAP))[n] * COMMAND_BYTES;
        REQUIRE(*(word *)(event + C_NUMBER) == taken);
        for (word at = C_FOLLOWS; at + 8 <= COMMAND_BYTES; at += 8) REQUIRE(*(word *)(event + at) == taken);
        taken++;
    }
}

static void take_some(void) {
    I(Q_SIZE) = QUEUED;
    take(state);
    check_events();
}

UNTOLD static void make_sound(void) {
    float *ready = (float *)(state + READY);
    for (int frame = 0; frame < QUANTUM; frame++)
        ready[frame] = ready[QUANTUM + frame] = (float)((I(POSITION) + frame) & 0xffffff);
}

static int engine(void *in, void *out, unsigned long frames, void *times, unsigned long flags, void *user) {
    take_some();
    for (int n = 0; n < 4; n++) {
        make_sound();
        tap(state);
        note(state, calls);
        report(state, calls);
        trace(state, calls + 1);
        calls++;
    }
    while (__atomic_load_n(&hangs, __ATOMIC_RELAXED)) sched_yield();
    return 0;
}

static void *device(void *handover) {
    static __thread float out[2 * 64];
    double times[3] = {0.0, 0.0, 0.0};
    while (!__atomic_load_n(&over, __ATOMIC_RELAXED)) {
        guarded(NULL, out, 64, times, 0, handover);
        sched_yield();
    }
    return NULL;
}

static word running;

static void *paced(void *unused) {
    static float out[2 * 64];
    double times[3] = {0.0, 0.0, 0.0};
    pace(&running, (word)engine, (word)state, 64 * 2e4, out, 64, 2, times);
    return NULL;
}

/* ---- Python: what Ring, Engine and Handover do ---- */

static word sent;

static word room(void) { return RING - sent + _observe(state + RING_READ); }

UNTOLD static void write_command(char *entry) {
    memset(entry, 0, COMMAND_BYTES); /* which is told */
    *(double *)(entry + C_TIME) = -1.0;
    *(word *)(entry + C_NUMBER) = sent;
    for (word at = C_FOLLOWS; at + 8 <= COMMAND_BYTES; at += 8) *(word *)(entry + at) = sent;
}

static void send_commands(word count, int early) {
    if (early) publish_at(state + RING_WRITTEN, sent + count);
    for (word n = 0; n < count; n++, sent++) write_command(state + RING_ENTRIES + sent % RING * COMMAND_BYTES);
    if (!early) publish_at(state + RING_WRITTEN, sent);
}

static word heard, noted, told, ended; /* what came next by now */

UNTOLD static void check_sound(const float *frames, word first) {
    for (int n = 0; n < 2 * QUANTUM; n++) REQUIRE(frames[n] == (float)((first + n / 2) & 0xffffff));
}

static void read_tap(void) {
    word written = _observe(state + TAP_WRITTEN), read = I(TAP_READ);
    for (; read < written; read += QUANTUM) {
        float frames[2 * QUANTUM];
        word first = ((word *)(state + TAP_FIRST))[read % TAP / QUANTUM];
        if (first < 0) continue; /* it was there from the beginning */
        memcpy(frames, state + TAP_FRAMES + read % TAP * 8, sizeof frames);
        check_sound(frames, first);
        REQUIRE(first >= heard);
        heard = first + QUANTUM;
    }
    publish_at(state + TAP_READ, written);
}

static void read_notes(void) {
    word written = _observe(state + NOTES_WRITTEN), read = I(NOTES_READ);
    for (; read < written; read++) {
        word *entry = (word *)(state + NOTES_ENTRIES + read % NOTES * NOTE_BYTES);
        if (entry[0] == 0) continue; /* it was there from the beginning */
        REQUIRE(entry[0] >= noted && ((double *)entry)[1] == (double)entry[0]);
        noted = entry[0] + 1;
    }
    publish_at(state + NOTES_READ, written);
}

static void read_trace(void) {
    word written = _observe(state + TRACE_WRITTEN), read = I(TRACE_READ);
    for (; read < written; read++) {
        char *entry = state + TRACE_ENTRIES + read % TRACED * TRACE_BYTES;
        if (read < 4 * (word)TRACED - 9) { /* it was there from the beginning */
            read = read < 3 * (word)TRACED + 100 ? read : 4 * (word)TRACED - 10;
            told += *(volatile word *)(entry + TRACE_SAMPLE);
            continue;
        }
        word sample = *(word *)(entry + TRACE_SAMPLE);
        REQUIRE(sample >= told && *(double *)(entry + TRACE_IMPULSE) == (double)sample);
        told = sample + 1;
    }
    publish_at(state + TRACE_READ, written);
}

static void read_ends(void) {
    word written = _observe(state + ENDS_WRITTEN);
    for (word *entry; ended < written; ended++) {
        entry = (word *)(state + ENDS_ENTRIES) + 2 * (ended % ENDED);
        REQUIRE(entry[0] == ended - ENDS_FIRST + 1 && entry[1] == entry[0]);
    }
}

enum { FREE, RUNNING, TAKEN };

static int take_away(char *handover) {
    _swap(handover + H_TURN, FREE, TAKEN);
    return _observe(handover + H_TURN) == TAKEN;
}

/* ---- The cases ---- */

/* Lay an engine out with rings that wrap soon, those to Python nearly full of zeros that nobody has read. */
static void lay_out(void) {
    I(RING_WRITTEN) = I(RING_READ) = sent = taken = (word)RING * 1000000 - 7;
    I(TAP_ON) = I(NOTES_ON) = I(TRACE_ON) = 1;
    I(CHANNELS) = 2;
    *(double *)(state + RATE) = 48000.0;
    I(CONTACT_SOUND) = -1;
    I(TAP_WRITTEN) = 4 * (word)TAP - 8 * QUANTUM, I(TAP_READ) = 3 * (word)TAP;
    for (word n = 0; n < TAP / QUANTUM; n++) ((word *)(state + TAP_FIRST))[n] = -QUANTUM;
    I(NOTES_WRITTEN) = 4 * (word)NOTES - 9, I(NOTES_READ) = 3 * (word)NOTES;
    I(TRACE_WRITTEN) = 4 * (word)TRACED - 9, I(TRACE_READ) = 3 * (word)TRACED;
    I(ENDS_WRITTEN) = ended = ENDS_FIRST;
    calls = 1;
    for (word n = 0; n < EVENTS; n++) ((word *)(state + Q_HEAP))[n] = n;
}

/* Wait until the engine has done more. */
static void wait_for_calls(word more) {
    word end = _observe(state + ENDS_WRITTEN) + more;
    while (_observe(state + ENDS_WRITTEN) < end) sched_yield();
}

static void read_all(void) { read_tap(), read_notes(), read_trace(), read_ends(); }

static void check_all(void) {
    while (taken < sent) engine(NULL, NULL, 64, NULL, 0, NULL);
    read_all();
    REQUIRE(taken == sent && ended == I(ENDS_WRITTEN) && sent > (word)RING * 1000000 + RING);
    REQUIRE(I(TAP_LOST) > 0 && I(NOTES_LOST) > 0 && I(TRACE_LOST) > 0);
}

static void *player(void *unused) {
    while (!__atomic_load_n(&over, __ATOMIC_RELAXED)) {
        engine(NULL, NULL, 64, NULL, 0, NULL);
        carom_pause_ns(50000);
    }
    return NULL;
}

/* An engine that one thread runs, with nothing but its rings to order what another one does. */
static void rings(void) {
    pthread_t thread;
    lay_out();
    send_commands(room(), careless);
    REQUIRE(room() == 0);
    pthread_create(&thread, NULL, player, NULL);
    /* One ring after another, as each orders what is done with all others. */
    while (room() == 0) sched_yield();
    send_commands(room(), careless);
    wait_for_calls(64), read_ends(); /* Python stalls: the other rings to it overflow */
    read_tap(), wait_for_calls(16), read_notes(), wait_for_calls(16), read_trace(), wait_for_calls(16);
    for (word end = sent + 2 * RING; sent < end;) {
        send_commands(draw(1 + (unsigned)room()) % 600, careless);
        read_all();
        carom_pause_ns(50000);
    }
    for (int n = 0; n < 20; n++) { /* a ring that is empty: each command is taken as it comes */
        while (room() < RING) sched_yield();
        send_commands(1, careless);
    }
    __atomic_store_n(&over, 1, __ATOMIC_RELAXED);
    pthread_join(thread, NULL);
    check_all();
}

/* Devices take turns with an engine; one hangs in it and comes back, one is the clock. */
static void engine_and_devices(void) {
    char handovers[2][HANDOVER_BYTES] = {{0}};
    pthread_t devices[2], clock;
    lay_out();
    for (int n = 0; n < 2; n++) {
        *(word *)(handovers[n] + H_CALLBACK) = (word)engine;
        *(word *)(handovers[n] + H_STATE) = (word)state;
        *(word *)(handovers[n] + H_CHANNELS) = 2;
        _swap(handovers[n] + H_TURN, FREE, TAKEN);
        pthread_create(&devices[n], NULL, device, handovers[n]);
    }
    /* Nobody takes what waits while no device has the engine: the ring fills up. */
    send_commands(room(), careless);
    REQUIRE(room() == 0);
    for (int round = 0; round < ROUNDS; round++) {
        char *handover = handovers[round % 2];
        int by_clock = round % 10 == 9;
        if (by_clock) {
            running = 1;
            pthread_create(&clock, NULL, paced, NULL);
            send_commands(draw(1 + (unsigned)room()) % 300, careless);
            carom_pause_ns(300000);
            publish_at(&running, 0);
            pthread_join(clock, NULL);
        } else {
            int hung = round % 8 == 5;
            word before = _observe(handover + H_CALLS);
            __atomic_store_n(&hangs, hung, __ATOMIC_RELAXED);
            _swap(handover + H_TURN, TAKEN, FREE);
            while (_observe(handover + H_CALLS) < before + 2 - hung) sched_yield();
            send_commands(draw(1 + (unsigned)room()) % 300, careless);
            if (hung) {
                while (_observe(handover + H_TURN) != RUNNING) sched_yield();
                for (int n = 0; n < 100; n++) REQUIRE(!take_away(handover)); /* it can't be taken away */
                __atomic_store_n(&hangs, 0, __ATOMIC_RELAXED);
            }
            if (round >= 6) read_tap(), read_notes(), read_trace(); /* not before they overflow */
            read_ends();
            while (!take_away(handover)) sched_yield();
        }
        word now = calls; /* nobody is in the engine */
        REQUIRE(now > 0);
    }
    __atomic_store_n(&over, 1, __ATOMIC_RELAXED);
    for (int n = 0; n < 2; n++) pthread_join(devices[n], NULL);
    check_all();
}

/* Two threads that send, one at a time: by Python's lock. */
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

static void *writer(void *unused) {
    for (int n = 0; n < 500; n++) {
        if (!careless) pthread_mutex_lock(&lock);
        if (room() > 10) send_commands(3, 0);
        if (!careless) pthread_mutex_unlock(&lock);
    }
    return NULL;
}

static void writers(void) {
    pthread_t threads[2];
    *(double *)(state + RATE) = 48000.0;
    for (word n = 0; n < EVENTS; n++) ((word *)(state + Q_HEAP))[n] = n;
    for (int n = 0; n < 2; n++) pthread_create(&threads[n], NULL, writer, NULL);
    while (taken < 3000) take_some();
    for (int n = 0; n < 2; n++) pthread_join(threads[n], NULL);
    REQUIRE(taken == sent && taken == 3000);
}

/* Blocks of engines on two threads that end where nothing comes for a while, and are started anew. */
enum { ADDED, TAKEN_JOBS, DONE, WORKING, ENDED_JOBS, COUNTS };
#define MOST 4
static word counts[COUNTS];
static char jobs[MOST * JOB_BYTES];
static double times[3];

static int block(void *in, void *out, unsigned long frames, void *told, unsigned long flags, void *user) {
    *(word *)user += 1;
    *(float *)out += 1.0f;
    return 0;
}

static void *worker(void *unused) {
    work(counts, jobs, MOST, (word)block, times);
    return NULL;
}

static void blocks(void) {
    static word engines[3];
    static float outs[3];
    pthread_t threads[2 * ROUNDS];
    int started = 0;
    word finished = 0;
    for (int round = 0; round < ROUNDS; round++) {
        if (round % 9 == 0 && started + 2 <= 2 * ROUNDS) {
            for (int n = 0; n < 2; n++) pthread_create(&threads[started++], NULL, worker, NULL);
        }
        for (int n = 0; n < 3; n++) {
            word added = counts[ADDED];
            if (added - finished >= MOST) finish(counts, jobs, MOST, (word)block, times), finished = _observe(counts);
            char *job = jobs + added % MOST * JOB_BYTES;
            if (careless) publish_at(counts + ADDED, added + 1);
            *(word *)(job + J_STATE) = (word)&engines[n];
            *(word *)(job + J_OUT) = (word)&outs[n];
            *(word *)(job + J_FRAMES) = *(word *)(job + J_CHANNELS) = 1;
            if (!careless) publish_at(counts + ADDED, added + 1);
            if (draw(3) == 0) sched_yield();
        }
        if (round % 3 == 0) carom_pause_ns(20000);
        finish(counts, jobs, MOST, (word)block, times), finished = _observe(counts);
        for (int n = 0; n < 3; n++) REQUIRE(engines[n] == round + 1 && outs[n] == (float)(round + 1));
    }
    publish_at(counts + ENDED_JOBS, 1);
    for (int n = 0; n < started; n++) pthread_join(threads[n], NULL);
    REQUIRE(_observe(counts + WORKING) == 0 && counts[DONE] == 3 * ROUNDS);
}

/* Datagrams, read by a thread that is woken, and stalls. */
#define DATAGRAMS 4000 /* of which the large ones fill the ring more than twice */
static sem_t bell;
static char *box;
static word arrived; /* of the thread that receives */

word carom_receive(word descriptor, word at, word most, word from, word length) {
    static unsigned seed = 7;
    seed = seed * 1664525u + 1013904223u;
    if (arrived == DATAGRAMS || (seed >> 9) % 8 == 0) {
        carom_pause_ns(arrived == DATAGRAMS ? 1000000 : 10000);
        return -1;
    }
    word size = arrived >= 20 && (seed >> 12) % 5 == 0 ? 60000 + (seed >> 8) % 5508 : (seed >> 8) % 300;
    memset((void *)at, (int)(arrived & 0xff), (size_t)size);
    word port = 1 + arrived % 3, host = 1 + arrived / 3 % 2;
    ((word *)from)[0] = host << 32 | port << 16 | 2; /* a sockaddr_in, */
    ((word *)from)[1] = arrived++;                   /* in whose padding the number is */
    return size;
}

void carom_send(word descriptor, word at, word size) { sem_post(&bell); }

static void *receiver(void *unused) {
    drain(box);
    return NULL;
}

/* Python stores these as whole words: room is counted by them, and nothing else follows from them. */
static void give_back(word group, word taken) {
    word *done = (word *)(box + BOX_DONE) + group;
    REQUIRE(0 <= group && group <= BOX_GROUPS);
    __atomic_store_n(done, *done + taken, __ATOMIC_RELAXED);
}

static void datagrams(void) {
    pthread_t thread;
    word got = 0, next = 0;
    static char expected[1 << 16];
    box = mmap(NULL, BOX_BYTES, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    *(word *)(box + BOX_KEY) = 0x2545f4914f6cdd1d;
    sem_init(&bell, 0, 0);
    pthread_create(&thread, NULL, receiver, NULL);
    while (got + _observe(box + BOX_DROPPED) < DATAGRAMS) {
        word read = *(word *)(box + BOX_READ);
        if (read == _confirm(box + BOX_WRITTEN)) {
            struct timespec until;
            clock_gettime(CLOCK_REALTIME, &until);
            until.tv_sec += 5;
            if (got + _observe(box + BOX_DROPPED) == DATAGRAMS) break;
            REQUIRE(sem_timedwait(&bell, &until) == 0);
            while (sem_trywait(&bell) == 0) {} /* hush */
            continue;
        }
        while (got == 20 && _observe(box + BOX_DROPPED) == 0) sched_yield(); /* it stalls: the ring fills up */
        char *entry = box + BOX_RING + read % BOX_WORDS * 8;
        word size = *(word *)entry & 0xffffffff, groups = *(word *)entry >> 32, number = ((word *)entry)[2];
        REQUIRE(number >= next);
        memset(expected, (int)(number & 0xff), (size_t)size);
        REQUIRE(memcmp(entry + 24, expected, (size_t)size) == 0);
        next = number + 1;
        word taken = 3 + (size + 7) / 8;
        read += taken;
        word rest = BOX_WORDS - read % BOX_WORDS;
        publish_at(box + BOX_READ, rest < BOX_LARGEST ? read + rest : read);
        give_back(groups & ((1 << BOX_OF_HOST) - 1), taken);
        give_back(groups >> BOX_OF_HOST, taken);
        give_back(BOX_GROUPS, taken);
        got++;
    }
    publish_at(box + BOX_STOPPED, 1);
    pthread_join(thread, NULL);
    REQUIRE(*(word *)(box + BOX_WRITTEN) > 2 * BOX_WORDS && *(word *)(box + BOX_DROPPED) > 0);
}

int main(int count, char **words) {
    static const struct {
        const char *name;
        void (*run)(void);
    } cases[] = {{"rings", rings}, {"devices", engine_and_devices}, {"writers", writers}, {"blocks", blocks}, {"datagrams", datagrams}};
    state = mmap(NULL, STATE_BYTES, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    REQUIRE(state != MAP_FAILED && count > 1);
    for (int n = 2; n < count; n++) {
        if (strcmp(words[n], "careless") == 0) careless = 1;
        else order_of[atoi(words[n])] = 0;
    }
    for (int n = 0; n < 5; n++)
        if (strcmp(words[1], cases[n].name) == 0) return cases[n].run(), 0;
    return 2;
}
