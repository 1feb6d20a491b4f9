/* What the files of the library share, and nobody else sees. */
#ifndef CAROM_INNER_H
#define CAROM_INNER_H

#include <setjmp.h>
#include <stddef.h>
#include <stdint.h>

#include "carom.h"

/* The engine and the tracker: functions over their memories, and what is said of all scenes. */
int carom_engine_callback(void *input, void *out, int64_t frames, void *times, int64_t flags, void *state);
void carom_engine_make_pulses(void *state, int64_t number);
int64_t carom_engine_ask(void *state, int64_t question, int64_t first, int64_t count);
int64_t carom_engine_judge(void *state, const void *command, int64_t tables);
int64_t carom_engine_copy(void *state, void *command, int64_t to, const void *changes);
extern const char carom_engine_rules[];
void carom_tracker_begin(int64_t memory, double rate, int64_t rolls);
int64_t carom_tracker_set_law(void *memory, int64_t a, int64_t b, const void *told);
int64_t carom_tracker_set_slide(void *memory, int64_t surface, double least, const void *command);
int64_t carom_tracker_make_body(void *memory, const void *told, const void *changes, int64_t slot, int64_t serial);
void carom_tracker_free_body(void *memory, int64_t body);
int64_t carom_tracker_move(void *memory, const void *told);
int64_t carom_tracker_touch(void *memory, const void *told);
int64_t carom_tracker_listen(void *memory, const void *told);
int64_t carom_tracker_govern(void *memory, double share);
int64_t carom_tracker_end_frame(void *memory, double seconds, int64_t position, int64_t waiting, double load);
int64_t carom_tracker_command_at(void *memory, int64_t number);
void carom_tracker_report(void *memory, void *told);

/* The library is one translation unit (library.c), so that a program that links it sees the names of carom.h alone. */
#define INNER static

/* A value of JSON. */
typedef struct value value;
struct value {
    enum { NOTHING, TRUTH, NUMBER, TEXT, LIST, MAP } kind;
    const char *key; /* in a map */
    const char *text;
    double number; /* of TRUTH 0 or 1 */
    value *first, *next;
};

INNER value *json_read(char *text, size_t size); /* changes the text, and points into it; NULL if it is no JSON */
INNER void json_free(value *root);
INNER const value *item(const value *map, const char *key); /* a value of kind NOTHING where there is none */
INNER const value *item_at(const value *list, long place);
INNER const value *item_of(const value *map, const char *prefix, const char *key);
INNER int place_of(const value *list, const char *text); /* -1: it is not there */
INNER double number_of(const value *map, const char *key);
INNER const char *text_of(const value *map, const char *key); /* "": it is none */
INNER int is_true(const value *map, const char *key);
INNER double decimal(const char *text, const char **end); /* whatever the locale says */

typedef struct {
    const char *name;
    int64_t place;
    int whole;
} field;

enum { LONGEST_NAME = 256, MOST_MACROS = 8, MOST_FOLLOWED = 8 };

typedef struct {
    char name[LONGEST_NAME];
    const value *said, *preset;
    int64_t slot, serial;
    double settings[16];
    unsigned given; /* bits: settings that a message has set */
    int64_t first, modes; /* in the engine's bank: where an object that was made live has them, and room for how many */
    double pitch;         /* times its own, of one that plays a note, else 0 */
    double change[3];     /* octaves: size, wave speed, density, beside the object of the score */
    const value *material;
    int body; /* number of its body, -1: it has none */
    double macros[MOST_MACROS]; /* in the order of the rules */
    int reshaped; /* the engine has the table of its macros */
} object;

/* The place of an object that was made live and freed. */
typedef struct {
    int64_t slot, first, modes, until; /* until: sample up to which messages to it may come */
    int64_t sent, taken; /* commands that were sent when it was freed; those that the engine had when it had all these, or -1 */
} vacancy;

/* A gesture that goes on; several may share an id, and then their number. */
typedef struct {
    char id[LONGEST_NAME], target[LONGEST_NAME];
    const char *action; /* in the map */
    int64_t number;
    struct {
        const value *law;
        double base; /* in the middle of its macro */
    } followed[MOST_FOLLOWED];
    int followed_count;
} running;

typedef struct {
    int64_t at, runs, commands, count;
} batch;

typedef struct {
    uint32_t hash[8];
    uint64_t size; /* bytes so far */
    uint8_t block[64];
} sum;

INNER void sum_begin(sum *of);
INNER void sum_add(sum *of, const uint8_t *bytes, size_t size);
INNER void sum_end(sum *of, uint8_t *made); /* 32 bytes */

struct carom {
    char *text, *rules_text;
    value *map, *rules; /* of the scene; of the engine */
    uint8_t *data;
    int64_t data_size;
    void *memory;
    uint8_t *state; /* in `memory`, at a multiple of 64 */
    int64_t state_size, command_size, entries, written, read, ring, position, ends, ended, most_ended;
    field *fields; /* sorted by their names */
    int field_count;
    batch *batches;
    int64_t batch_count, next;
    int live, channels, sensors; /* channels: with those of sensors */
    int64_t tables;              /* of pulses */
    double rate;
    int64_t computed, left_out;
    int64_t lost; /* what the sender knows of that found no room in the engine */
    uint8_t *inbox; /* commands from the thread that sends to the one that computes: as many as the engine's ring has */
    int64_t inbox_written, inbox_read;
    /* of messages */
    object *objects;
    int object_count, object_room;
    vacancy *freed; /* by objects that were made live */
    int freed_count;
    void *touching, *touched; /* the tracker's memory, NULL: the scene has no bodies; and what holds it */
    running *gestures; /* the oldest first */
    int gesture_count, gesture_room;
    int64_t made, ends_read, serial, slot, mode, gesture_number;
    char told[512];
    jmp_buf refused;
};

INNER int64_t whole_at(const carom *scene, int64_t place); /* of the engine's memory, with acquire ordering */
INNER void whole_put(carom *scene, int64_t place, int64_t number); /* with release ordering */
INNER const field *field_of(const carom *scene, const char *prefix, const char *name); /* NULL: there is none */
INNER double field_read(const carom *scene, const uint8_t *command, const char *name);
INNER void field_write(const carom *scene, uint8_t *command, const char *prefix, const char *name, double number);
INNER const value *part(const carom *scene, const char *name); /* of the engine's rules, else of the scene's map */
INNER int64_t whole_in(carom *scene, const value *of, const char *name, double low, double high); /* or it refuses */
INNER void expect_command(carom *scene, const uint8_t *command); /* refuses one that is none for the engine */
INNER int64_t room(const carom *scene);               /* for so many commands */
INNER int post(carom *scene, const uint8_t *command); /* 0: there is no room */
INNER uint8_t *zeros(void **memory, size_t size);
INNER void messages_begin(carom *scene);
INNER void bodies_begin(carom *scene);
INNER int body_like(carom *scene, const value *row, const object *made, int64_t material);
INNER void body_gone(carom *scene, int body);
INNER int messages_perform(carom *scene, const char *message, double time);

#endif
