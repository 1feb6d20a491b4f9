/* Notes, expressions and macros as messages. */
#include "instrument.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { S_TUNE, S_GAIN, S_PAN, S_DECAY, S_DAMP };

static const char *const SETTING[SETTINGS] = {"tune", "gain", "pan", "decay", "damp"};

static double clamped(double value, double low, double high) {
    return value < low ? low : value > high ? high : value;
}

/* Send a message of up to two words and numbers; whatever the locale says, a number has a point. */
static int tell(instrument *of, int copy, const char *action, const double *numbers, int count, const char *striker) {
    char message[512];
    size_t used = (size_t)snprintf(message, sizeof message, "\"/object/%.200s", of->object->name);
    if (copy >= 0) used += (size_t)snprintf(message + used, sizeof message - used, ".%d", copy);
    used += (size_t)snprintf(message + used, sizeof message - used, "/%s\"", action);
    for (int n = 0; n < count; n++) {
        char *number = message + used + 1;
        used += (size_t)snprintf(message + used, sizeof message - used, " %.17g", numbers[n]);
        for (; *number; number++)
            if (!strchr("+-e0123456789", *number)) *number = '.';
    }
    if (striker) snprintf(message + used, sizeof message - used, " striker %.100s", striker);
    double frame = (double)of->frame + (double)carom_delay(of->scene);
    return carom_send(of->scene, message, frame / carom_rate(of->scene));
}

static bool is_meant(const body *each, address key) {
    return (key.id < 0 || each->id < 0 || key.id == each->id) && (key.port < 0 || key.port == each->port) &&
           (key.channel < 0 || key.channel == each->channel) && (key.key < 0 || key.key == each->key);
}

/* --- bodies --- */

/* Bring the settings of a body to what macros, expressions and the hand on a released one ask for. */
static void settle(instrument *of, body *each) {
    const instrument_object *object = of->object;
    const double *asked = each->expressions, *values = of->values;
    double hand = each->choked ? 1.0 : each->held ? 0.0 : values[RELEASE];
    double damp = fmax(fmax(object->damp, values[DAMP]), fmax(asked[PRESSURE], hand));
    double wanted[SETTINGS] = {
        [S_TUNE] = values[TUNE] + asked[BEND] + each->note - each->copy,
        [S_GAIN] = values[GAIN] + asked[VOLUME] + object->gain,
        [S_PAN] = clamped(values[PAN] + asked[BALANCE] + object->pan, -1.0, 1.0),
        [S_DECAY] = values[DECAY] * object->decay,
        [S_DAMP] = damp,
    };
    for (int n = 0; n < SETTINGS; n++) {
        double number = wanted[n];
        if (number == each->sent[n]) continue;
        if (n == S_TUNE && isnan(of->pitch)) continue;
        if (n == S_TUNE) number = clamped(number + each->copy - of->pitch, -60.0, 60.0);
        if (n == S_GAIN) number = clamped(number, -120.0, 40.0);
        if (tell(of, each->copy, SETTING[n], &number, 1, NULL)) each->sent[n] = wanted[n];
    }
}

/* Turn the object's macros, which its bodies follow. */
static void turn(instrument *of) {
    for (int n = 0; n < OF_OBJECT; n++) {
        double value = of->values[FIRST_OF_OBJECT + n];
        char action[64];
        if (value == of->turned[n]) continue;
        snprintf(action, sizeof action, "macro/%s", macros[FIRST_OF_OBJECT + n].name);
        action[strlen("macro/")] |= 32; /* its first letter, as messages have it */
        if (tell(of, -1, action, &value, 1, NULL)) of->turned[n] = value;
    }
}

/* The body of a key: its own; a new one; or, where the scene has no room, the one that was struck longest ago. */
static body *body_of(instrument *of, int note, bool *is_new) {
    body *oldest = NULL;
    *is_new = false;
    for (int n = 0; n < of->body_count; n++) {
        body *each = &of->bodies[n];
        if (each->note == note) return each;
        if (!oldest || each->struck < oldest->struck) oldest = each;
    }
    if (of->body_count == KEYS) return oldest;
    *is_new = true;
    body *made = &of->bodies[of->body_count];
    *made = (body){.note = note, .copy = note, .ended = true};
    made->sent[S_GAIN] = of->object->gain;
    made->sent[S_PAN] = of->object->pan;
    made->sent[S_DECAY] = of->object->decay;
    made->sent[S_DAMP] = of->object->damp;
    return made;
}

static void finish(body *each, note_ended ended, void *context) {
    if (!each->ended && ended) ended(context, each);
    each->ended = true;
    each->held = each->let_go = false;
}

static double own_bend(const instrument *of, int channel) { return of->channels[channel].bend * of->channels[channel].range; }

/* The bend of a channel of MIDI in semitones, with that of its zone. */
static double bend_of(const instrument *of, int channel) {
    int manager = of->channels[channel].manager;
    return own_bend(of, channel) + (manager < 0 ? 0.0 : own_bend(of, manager));
}

/* Whether the pedal of a channel of MIDI is down, or that of its zone. */
static bool is_sustained(const instrument *of, int channel) {
    if (channel < 0 || channel >= CHANNELS_OF_MIDI) return false;
    int manager = of->channels[channel].manager;
    return of->channels[channel].pedal || (manager >= 0 && of->channels[manager].pedal);
}

/* Send the message that strikes a body. */
static int blow(instrument *of, const body *each, double velocity) {
    int channel = each->channel;
    double told = channel >= 0 && channel < CHANNELS_OF_MIDI ? of->channels[channel].position : NAN;
    double position = isnan(told) ? of->values[POSITION] : told;
    int striker = (int)of->values[STRIKER];
    const double numbers[] = {each->copy, clamped(velocity, 1.0, 127.0), position};
    int count = position == of->object->position ? 2 : 3;
    return tell(of, -1, "note", numbers, count, striker > 0 ? strikers[striker] : NULL);
}

void instrument_strike(instrument *of, address key, double velocity, note_ended ended, void *context) {
    bool is_new;
    if (key.key < 0 || key.key > 127 || isnan(velocity)) return;
    turn(of);
    body *each = body_of(of, key.key, &is_new);
    finish(each, ended, context);
    each->note = each->key = key.key;
    each->port = key.port;
    each->channel = key.channel;
    each->id = key.id;
    memset(each->expressions, 0, sizeof each->expressions);
    if (key.channel >= 0 && key.channel < CHANNELS_OF_MIDI) {
        each->expressions[BEND] = bend_of(of, key.channel);
        each->expressions[PRESSURE] = of->channels[key.channel].pressure;
    }
    each->held = true;
    each->choked = each->let_go = false;
    if (!is_new) settle(of, each);
    int is_struck = blow(of, each, velocity);
    if (!is_struck && is_new && of->body_count) { /* no room for another: one that is there takes its place */
        body kept = *each;
        each = &of->bodies[0];
        for (int n = 1; n < of->body_count; n++)
            if (of->bodies[n].struck < each->struck) each = &of->bodies[n];
        finish(each, ended, context);
        kept.copy = each->copy;
        memcpy(kept.sent, each->sent, sizeof kept.sent);
        *each = kept;
        settle(of, each);
        is_struck = blow(of, each, velocity);
        is_new = false;
    }
    if (!is_struck) {
        each->held = false;
        return;
    }
    if (is_new) {
        of->body_count++;
        settle(of, each);
    }
    each->ended = false;
    each->struck = ++of->blows;
}

void instrument_release(instrument *of, address key) {
    for (int n = 0; n < of->body_count; n++) {
        body *each = &of->bodies[n];
        if (!each->held || !is_meant(each, key)) continue;
        each->let_go = is_sustained(of, each->channel);
        each->held = each->let_go;
        if (!each->held) settle(of, each);
    }
}

void instrument_choke(instrument *of, address key, note_ended ended, void *context) {
    for (int n = 0; n < of->body_count; n++) {
        body *each = &of->bodies[n];
        if (each->ended || !is_meant(each, key)) continue;
        finish(each, ended, context);
        each->choked = true;
        settle(of, each);
    }
}

void instrument_end(instrument *of, note_ended ended, void *context) {
    for (int n = 0; n < of->body_count; n++)
        if (!of->bodies[n].held) finish(&of->bodies[n], ended, context);
}

void instrument_express(instrument *of, address key, int expression, double value) {
    for (int n = 0; n < of->body_count; n++) {
        body *each = &of->bodies[n];
        if (each->ended || !is_meant(each, key)) continue;
        each->expressions[expression] = value;
        settle(of, each);
    }
}

void instrument_set(instrument *of, int macro, double value) {
    of->values[macro] = value;
    if (!of->scene || macro == POSITION || macro == STRIKER) return; /* of the next blow */
    if (of->body_count) turn(of); /* else the first blow does */
    for (int n = 0; n < of->body_count; n++) settle(of, &of->bodies[n]);
}

/* --- MIDI --- */

enum { BEND_RANGE = 0, MPE_ZONE = 6, NO_PARAMETER = 0x3FFF, MPE_RANGE = 48, USUAL_RANGE = 2 };

/* Lay out a zone of MPE, whose manager is the first channel or the last one: its members bend far. */
static void zone(instrument *of, int manager, int members) {
    for (int n = 1; n < CHANNELS_OF_MIDI; n++) {
        int channel = manager ? manager - n : n;
        if (n > members && of->channels[channel].manager != manager) continue;
        of->channels[channel].range = n <= members ? MPE_RANGE : USUAL_RANGE;
        of->channels[channel].manager = n <= members ? manager : -1;
    }
}

/* Tell the notes of a channel of MIDI, and of those that it manages, their bend. */
static void bend(instrument *of, int16_t port, int channel) {
    for (int n = 0; n < CHANNELS_OF_MIDI; n++) {
        const address all = {-1, port, (int16_t)n, -1};
        if (n == channel || of->channels[n].manager == channel) instrument_express(of, all, BEND, bend_of(of, n));
    }
}

/* A keyboard for MPE may not say so. It sets a channel up before each note (MPE 1.0, 2.2.5), or plays two other than the
   first at once. */
static void look_for_zone(instrument *of, int channel) {
    bool is_alone = true;
    for (int n = 0; n < of->body_count; n++) {
        const body *each = &of->bodies[n];
        if (each->held && each->channel > 0 && each->channel < CHANNELS_OF_MIDI && each->channel != channel) is_alone = false;
    }
    if (channel > 0 && !of->zoned && (of->channels[channel].set_up || !is_alone)) {
        of->zoned = true;
        zone(of, 0, CHANNELS_OF_MIDI - 1);
        for (int n = 1; n < CHANNELS_OF_MIDI; n++) bend(of, -1, n);
    }
    of->channels[channel].set_up = false;
}

/* The range of bends of a channel: of all members of a zone, if it is one of them. */
static void set_range(instrument *of, int16_t port, int channel, double semitones) {
    int manager = of->channels[channel].manager;
    of->zoned = true;
    for (int n = 0; n < CHANNELS_OF_MIDI; n++) {
        if (n != channel && (manager < 0 || of->channels[n].manager != manager)) continue;
        of->channels[n].range = semitones;
        bend(of, port, n);
    }
}

/* Move the pedal: as it comes up, what it held is let go. */
static void move_pedal(instrument *of, int channel, bool is_down) {
    of->channels[channel].pedal = is_down;
    for (int n = 0; n < of->body_count && !is_down; n++) {
        body *each = &of->bodies[n];
        if (!each->let_go || is_sustained(of, each->channel)) continue;
        each->held = each->let_go = false;
        settle(of, each);
    }
}

static void control(instrument *of, int16_t port, int channel, int number, int value, note_ended ended, void *context) {
    int *parameter = &of->channels[channel].parameter;
    const address all = {-1, port, (int16_t)channel, -1};
    if (number == 64) move_pedal(of, channel, value >= 64);
    if (number == 74) of->channels[channel].position = value / 127.0;
    if (number == 74) of->channels[channel].set_up = true;
    if (number == 101) *parameter = (*parameter & 0x7F) | value << 7;
    if (number == 100) *parameter = (*parameter & 0x3F80) | value;
    if (number == 98 || number == 99) *parameter = NO_PARAMETER;
    if (number == 6 && *parameter == BEND_RANGE) set_range(of, port, channel, value);
    if (number == 6 && *parameter == MPE_ZONE && channel % 15 == 0) {
        of->zoned = true;
        zone(of, channel, value);
    }
    if (number == 120) instrument_choke(of, all, ended, context);
    if (number == 123) instrument_release(of, all);
}

void instrument_midi(instrument *of, int16_t port, const uint8_t *bytes, note_ended ended, void *context) {
    int channel = bytes[0] & 15, first = bytes[1] & 127, second = bytes[2] & 127;
    const address key = {-1, port, (int16_t)channel, (int16_t)first}, all = {-1, port, (int16_t)channel, -1};
    switch (bytes[0] >> 4) {
    case 9:
        if (second) {
            look_for_zone(of, channel);
            instrument_strike(of, key, second, ended, context);
            break;
        } /* else as 8 */
    /* fall through */
    case 8: instrument_release(of, key); break;
    case 10: instrument_express(of, key, PRESSURE, second / 127.0); break;
    case 11: control(of, port, channel, first, second, ended, context); break;
    case 13:
        of->channels[channel].pressure = first / 127.0;
        of->channels[channel].set_up = true;
        instrument_express(of, all, PRESSURE, first / 127.0);
        break;
    case 14:
        of->channels[channel].bend = ((second << 7 | first) - 8192) / 8192.0;
        of->channels[channel].set_up = true;
        bend(of, port, channel);
        break;
    }
}

/* --- the scene --- */

void instrument_begin(instrument *of) {
    of->body_count = 0;
    of->blows = 0;
    of->zoned = false;
    for (int n = 0; n < OF_OBJECT; n++) of->turned[n] = macros[FIRST_OF_OBJECT + n].usual;
    for (int n = 0; n < CHANNELS_OF_MIDI; n++) {
        of->channels[n].bend = of->channels[n].pressure = 0.0;
        of->channels[n].position = NAN;
        of->channels[n].range = USUAL_RANGE;
        of->channels[n].manager = -1;
        of->channels[n].parameter = NO_PARAMETER;
        of->channels[n].pedal = of->channels[n].set_up = false;
    }
    carom_load(of->scene, 1);
}

bool instrument_open(instrument *of, const instrument_object *object, const void *bytes, size_t size) {
    const char *name;
    of->object = object;
    of->scene = carom_open(bytes, size, 1);
    if (!of->scene) return false;
    of->pitch = NAN;
    for (int n = 0; (name = carom_object(of->scene, n)); n++)
        if (!strcmp(name, object->name)) of->pitch = carom_pitch(of->scene, n);
    instrument_begin(of);
    return true;
}

void instrument_close(instrument *of) {
    carom_close(of->scene);
    of->scene = NULL;
}
