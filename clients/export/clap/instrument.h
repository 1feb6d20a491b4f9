/* An object of a scene as an instrument: notes, expressions and macros, which become messages to the scene.

   Each key has a body of its own: a copy of the object, tuned to the key's note and made when that is first played. It is
   struck anew where it rings. Nothing here allocates or locks, but instrument_open. */
#ifndef INSTRUMENT_H
#define INSTRUMENT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "carom.h"

/* What a plug-in is made of: scene.h fills them in. */
typedef struct {
    double rate; /* Hz */
    const unsigned char *bytes, *end;
} baked_scene;

typedef struct {
    const char *name;
    double position, gain, pan, decay, damp; /* as the score makes it, in the units of messages */
} instrument_object;

enum { POSITION, STRIKER, TUNE, DECAY, DAMP, RELEASE, GAIN, PAN, FIRST_OF_OBJECT, OF_OBJECT = 8, MACROS = FIRST_OF_OBJECT + OF_OBJECT };

typedef struct {
    const char *name, *unit;
    double low, high, usual; /* of POSITION: that of the object; of STRIKER: the last one's place is `high` */
} macro;

extern const macro macros[MACROS];
extern const char *const strikers[]; /* the first one: whatever the object is usually struck with */
extern const int striker_count;

/* What an expression changes, for one key. */
enum { BEND, VOLUME, BALANCE, PRESSURE, EXPRESSIONS };

enum { KEYS = 64, SETTINGS = 5, CHANNELS_OF_MIDI = 16 };

typedef struct {
    double note;                    /* that it is tuned to */
    int copy;                       /* the note in the name of its body: NAME.COPY */
    int32_t id;                     /* of the note that was played last; -1: it has none */
    int16_t port, channel, key;
    bool held, choked, ended;       /* ended: the host knows that the note has */
    bool let_go;                    /* and held by a pedal alone */
    int64_t struck;                 /* the number of the blow */
    double expressions[EXPRESSIONS];
    double sent[SETTINGS];
} body;

/* Notes by these values; -1 of any is all. */
typedef struct {
    int32_t id;
    int16_t port, channel, key;
} address;

typedef struct {
    carom *scene;
    const instrument_object *object;
    double pitch;   /* the note that it plays by itself; NAN: it has none */
    uint64_t frame; /* at which messages are carried out, as much later as the scene's delay says */
    double values[MACROS];
    double turned[OF_OBJECT]; /* the object's macros, as they were sent */
    body bodies[KEYS];
    int body_count;
    int64_t blows;
    bool zoned; /* a message has laid out zones of MPE, or bends */
    struct {
        double bend, range, pressure, position; /* -1 to 1, semitones, 0 to 1, NAN before it is told */
        int manager;                            /* of the zone of MPE that it is a member of; -1: of none */
        int parameter;                          /* that is registered, and changed by the next data */
        bool pedal;                             /* is down: what is let go is held */
        bool set_up;                            /* by a bend, pressure or controller 74, for its next note */
    } channels[CHANNELS_OF_MIDI];
} instrument;

/* A note that has ended, for the host. */
typedef void (*note_ended)(void *context, const body *of);

bool instrument_open(instrument *of, const instrument_object *object, const void *bytes, size_t size);
void instrument_begin(instrument *of); /* anew: no key has been played */
void instrument_close(instrument *of);

void instrument_set(instrument *of, int macro, double value);
/* velocity: of MIDI, 1 to 127. */
void instrument_strike(instrument *of, address key, double velocity, note_ended ended, void *context);
void instrument_release(instrument *of, address key);
void instrument_choke(instrument *of, address key, note_ended ended, void *context);
void instrument_express(instrument *of, address key, int expression, double value);
void instrument_midi(instrument *of, int16_t port, const uint8_t *bytes, note_ended ended, void *context);
void instrument_end(instrument *of, note_ended ended, void *context); /* the notes that are held no more */

#endif
