/* Messages, as OSC has them, to the engine's commands. All that it knows of gestures, values and ranges is in the map. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "messages.h"

#define SLOWEST 0.05    /* m/s of the velocities 1 and 127 */
#define FASTEST 5.0

enum { LIVE = 1 << 20, MOST_POINTS = 64 };

static void perform(carom *scene, const char *address, const message *from, const word *words, int count, double time);

void begin(carom *scene, command *made, const call *told, const char *kind) {
    memset(made->bytes, 0, (size_t)scene->command_size);
    field_write(scene, made->bytes, "", "time", told->time);
    field_write(scene, made->bytes, "", "kind", number_of(part(scene, "kinds"), kind));
    field_write(scene, made->bytes, "", "channel", -1.0);
}

void set(carom *scene, command *made, const char *name, double number) {
    field_write(scene, made->bytes, "", name, number);
}

void about(carom *scene, command *made, const object *of) {
    set(scene, made, "slot", (double)of->slot);
    set(scene, made, "serial", (double)of->serial);
}

void send_command(carom *scene, const command *made) {
    expect_command(scene, made->bytes);
    if (!post(scene, made->bytes))
        refuse(scene, "no capacity for another command: %lld wait", (long long)scene->ring);
}

/* Send a command for each point, or none where there is no room for all. */
static void send_points(carom *scene, command *made, const call *told) {
    point found[MOST_POINTS];
    int count = points(scene, told->verb, told->from, told->words, told->count, found, MOST_POINTS);
    if (room(scene) < count) refuse(scene, "no capacity for %d more commands", count);
    for (int n = 0; n < count; n++) {
        set(scene, made, "value", found[n].value);
        set(scene, made, "ramp.after", found[n].after);
        set(scene, made, "ramp.over", found[n].over);
        set(scene, made, "ramp.curve", found[n].curve);
        send_command(scene, made);
    }
}

static void name_into(carom *scene, char *into, const char *text) {
    if (strlen(text) >= LONGEST_NAME) refuse(scene, "%.80s...: expected a name of at most 255 bytes", text);
    strcpy(into, text);
}

/* --- what goes on --- */

running *running_by(const carom *scene, const char *id) {
    for (int n = 0; n < scene->gesture_count; n++)
        if (!strcmp(scene->gestures[n].id, id)) return &scene->gestures[n];
    return NULL;
}

int goes_on(const carom *scene, const char *id, const char *target, const char *action) {
    for (int n = 0; n < scene->gesture_count; n++) {
        const running *each = &scene->gestures[n];
        if (!strcmp(each->id, id) && !strcmp(each->target, target) && !strcmp(each->action, action)) return 1;
    }
    return 0;
}

/* Forget the oldest gesture of a number, or the youngest. */
static void forget(carom *scene, int64_t number, int youngest) {
    int gone = -1;
    for (int n = 0; n < scene->gesture_count; n++)
        if (scene->gestures[n].number == number && (gone < 0 || youngest)) gone = n;
    if (gone < 0) return;
    scene->gesture_count--;
    running *place = &scene->gestures[gone];
    memmove(place, place + 1, (size_t)(scene->gesture_count - gone) * sizeof *place);
}

/* Learn which gestures have ended. */
void collect(carom *scene) {
    int64_t count = whole_at(scene, scene->ended), joined = (int64_t)number_of(scene->rules, "joined");
    int64_t n = count - scene->most_ended > scene->ends_read ? count - scene->most_ended : scene->ends_read;
    for (; n < count; n++) {
        int64_t at = scene->ends + 16 * (n % scene->most_ended);
        forget(scene, whole_at(scene, at), whole_at(scene, at + 8) == joined);
    }
    scene->ends_read = count;
}

/* The number of a gesture that begins. */
int64_t start(carom *scene, const char *id, const char *target, const char *action) {
    if (scene->gesture_count == scene->gesture_room)
        refuse(scene, "no capacity for another gesture with an id: %d go on", scene->gesture_room);
    const running *known = running_by(scene, id);
    running *begun = &scene->gestures[scene->gesture_count];
    name_into(scene, begun->id, id);
    name_into(scene, begun->target, target);
    begun->action = item(part(scene, "gestures"), action)->key;
    begun->number = known ? known->number : ++scene->gesture_number;
    scene->gesture_count++;
    return begun->number;
}

/* --- objects --- */

object *object_by(const carom *scene, const char *name) {
    for (int n = 0; n < scene->object_count; n++)
        if (!strcmp(scene->objects[n].name, name)) return &scene->objects[n];
    return NULL;
}

static int64_t laid(const carom *scene, const object *of, const char *name) {
    return (int64_t)field_read(scene, scene->data + (int64_t)number_of(of->said, "made"), name);
}

static void add_object(carom *scene, object made, const char *name) {
    if (scene->object_count == scene->object_room) refuse(scene, "no capacity for another object");
    name_into(scene, made.name, name);
    scene->objects[scene->object_count++] = made;
}

static void remove_object(carom *scene, object *gone) {
    scene->object_count--;
    memmove(gone, gone + 1, (size_t)(scene->objects + scene->object_count - gone) * sizeof *gone);
}

/* Make an object of another's modes, tuned to a note; a plate's copies do not stretch. */
static void copy(carom *scene, const object *of, const char *name, double note, double time) {
    static const char *const columns[] = {"frequency", "sigma", "weight", "balance"};
    const value *state = part(scene, "state");
    int64_t size = laid(scene, of, "layout.size"), first = laid(scene, of, "layout.first");
    double pitch = number_of(of->said, "pitch");
    if (!(pitch > 0.0)) refuse(scene, "note: it has no audible mode, and so no pitch");
    if (scene->mode + size > (int64_t)number_of(state, "modes") || scene->slot + 1 >= scene->object_room)
        refuse(scene, "note = %g: no capacity for another object", note);
    int64_t next = __atomic_load_n(&scene->next, __ATOMIC_ACQUIRE);
    if (!scene->live && (int64_t)number_of(of->said, "batch") >= next)
        refuse(scene, "%.80s: its object is not there yet", name);
    for (int n = 0; n < 4; n++) {
        uint8_t *column = scene->state + (int64_t)number_of(state, columns[n]);
        memcpy(column + 8 * scene->mode, column + 8 * first, 8 * (size_t)size);
    }
    command made;
    memcpy(made.bytes, scene->data + (int64_t)number_of(of->said, "made"), (size_t)scene->command_size);
    object other = *of;
    other.slot = scene->slot + 1;
    other.serial = scene->serial + 1;
    about(scene, &made, &other);
    set(scene, &made, "time", time);
    set(scene, &made, "layout.first", (double)scene->mode);
    set(scene, &made, "layout.sheet", -1.0);
    for (const value *each = part(scene, "settings")->first; each; each = each->next) {
        int place = (int)each->number;
        if (!(of->given >> place & 1)) continue;
        const value *declared = item_at(item(item_of(part(scene, "verbs"), "/object/NAME/", each->key), "required"), 0);
        field_write(scene, made.bytes, "settings.", each->key, in_engine(declared, of->settings[place]));
    }
    set(scene, &made, "settings.tune", 440.0 * pow(2.0, (note - 69.0) / 12.0) / pitch);
    send_command(scene, &made);
    add_object(scene, other, name);
    scene->slot++;
    scene->serial++;
    scene->mode += size;
}

/* Strike a copy of an object that is tuned to a note; it is made when the note is first played. */
static void note(carom *scene, const call *told, const object *of) {
    table given, defaults;
    parse(scene, told->address, told->verb, told->words, told->count, &given, &defaults);
    const named *number = entry(&given, "note"), *velocity = entry(&given, "velocity");
    if (!number || !velocity) refuse(scene, "note: expected a note and a velocity");
    if (velocity->number == 0.0) return;
    char name[LONGEST_NAME], address[LONGEST_NAME + 32];
    if (snprintf(name, sizeof name, "%s.%.15g", told->target, number->number) >= (int)sizeof name)
        refuse(scene, "%.80s: too long a name", told->target);
    if (!object_by(scene, name)) copy(scene, of, name, number->number, told->time);
    double share = (fmax(velocity->number, 1.0) - 1.0) / 126.0;
    word words[MOST_WORDS];
    memcpy(words, told->words + 1, (size_t)(told->count - 1) * sizeof *words);
    words[0] = (word){A_NUMBER, "velocity", SLOWEST * pow(FASTEST / SLOWEST, share), 0, 0};
    snprintf(address, sizeof address, "/object/%s/impact", name);
    perform(scene, address, told->from, words, told->count - 1, told->time);
}

/* --- messages --- */

/* True if one of the gestures of an id has what a message steers. */
static int has_steered(const carom *scene, const call *told) {
    for (int n = 0; n < scene->gesture_count; n++) {
        const running *each = &scene->gestures[n];
        if (strcmp(each->id, told->target)) continue;
        const value *steerable = item(item(part(scene, "gestures"), each->action), "steerable");
        for (const value *name = steerable->first; name; name = name->next)
            if (!strcmp(name->text, told->action)) return 1;
    }
    return 0;
}

static void steer(carom *scene, const call *told) {
    command made;
    collect(scene);
    const running *found = running_by(scene, told->target);
    if (!found) refuse(scene, "%.80s: no such gesture is running", told->target);
    int stops = !strcmp(told->action, "stop");
    if (!stops && !has_steered(scene, told))
        refuse(scene, "%.80s: what goes on (%s) has no %s", told->target, found->action, told->action);
    begin(scene, &made, told, stops ? "STOP" : "STEER");
    set(scene, &made, "gesture", (double)found->number);
    if (stops) {
        send_command(scene, &made);
        return;
    }
    set(scene, &made, "parameter", number_of(part(scene, "steerable"), told->action));
    send_points(scene, &made, told);
}

static void of_engine(carom *scene, const call *told) {
    command made;
    char kind[32];
    size_t size = 0;
    for (const char *each = told->address + 1; *each && size + 1 < sizeof kind; each++)
        kind[size++] = (char)(*each >= 'a' && *each <= 'z' ? *each - 32 : *each);
    kind[size] = 0;
    begin(scene, &made, told, kind);
    if (is_true(told->verb, "changes")) {
        send_points(scene, &made, told);
        return;
    }
    table given, defaults;
    parse(scene, told->address, told->verb, told->words, told->count, &given, &defaults);
    const named *first = given.count ? &given.entries[0] : NULL;
    double number = first ? first->number : 0.0;
    if (first && first->text) {
        int is_on = !strcmp(first->text, "on") || !strcmp(first->text, "1");
        number = !strcmp(kind, "ACCURACY") ? number_of(part(scene, "levels"), first->text)
                 : !strcmp(kind, "BANK")   ? place_of(part(scene, "forms"), first->text)
                                           : is_on;
    }
    set(scene, &made, "value", number);
    send_command(scene, &made);
}

static void of_object(carom *scene, const call *told) {
    object *of = object_by(scene, told->target);
    if (!of) refuse_all(scene, "object", told->target, part(scene, "objects")->first);
    if (item(part(scene, "gestures"), told->action)->kind == MAP) {
        gesture(scene, told, of);
        return;
    }
    if (!strcmp(told->action, "note")) {
        note(scene, told, of);
        return;
    }
    command made;
    int changes = is_true(told->verb, "changes");
    begin(scene, &made, told, changes ? "SET" : "FREE");
    about(scene, &made, of);
    if (changes) {
        int place = (int)number_of(part(scene, "settings"), told->action);
        set(scene, &made, "parameter", place);
        send_points(scene, &made, told);
        if (told->words[0].kind == A_NUMBER && place < 16) {
            of->settings[place] = told->words[0].number;
            of->given |= 1u << place;
        }
        return;
    }
    table given, defaults;
    parse(scene, told->address, told->verb, told->words, told->count, &given, &defaults);
    const named *at_once = entry(&given, "at_once");
    set(scene, &made, "value", at_once ? at_once->number : 0.0);
    send_command(scene, &made);
    remove_object(scene, of);
}

/* The two parts of an address /GROUP/TARGET/ACTION; 0: it has others. */
static int parts_of(const char *address, const char *group, char *target, const char **action) {
    size_t size = strlen(group);
    if (strncmp(address, group, size)) return 0;
    const char *slash = strchr(address + size, '/');
    if (!slash || strchr(slash + 1, '/') || slash - address - size >= LONGEST_NAME) return 0;
    memcpy(target, address + size, (size_t)(slash - address) - size);
    target[slash - address - size] = 0;
    *action = slash + 1;
    return 1;
}

/* The argument of a button, at an address without arguments: 1 as it is pressed, 0 as it is let go; -1: it is none. */
static int button_of(const call *told) {
    int bare = !is_true(told->verb, "changes") && item(told->verb, "required")->kind != LIST &&
               item(told->verb, "optional")->kind != LIST && item(told->verb, "keys")->kind != LIST;
    if (!bare || told->count != 1 || told->words[0].kind != A_NUMBER) return -1;
    double number = told->words[0].number;
    return number == 0.0 || number == 1.0 ? number == 1.0 : -1;
}

static void perform(carom *scene, const char *address, const message *from, const word *words, int count, double time) {
    char target[LONGEST_NAME] = "";
    call told = {address, target, "", NULL, from, words, count, time};
    int on_object = parts_of(address, "/object/", target, &told.action);
    int on_gesture = !on_object && parts_of(address, "/gesture/", target, &told.action);
    const value *verbs = part(scene, "verbs");
    told.verb = on_object    ? item_of(verbs, "/object/NAME/", told.action)
                : on_gesture ? item_of(verbs, "/gesture/ID/", told.action)
                             : item(verbs, address);
    if (told.verb->kind != MAP) refuse_all(scene, "address in an exported scene", address, verbs->first);
    int button = button_of(&told);
    if (!button) return;
    if (button > 0) told.count = 0;
    if (on_object)
        of_object(scene, &told);
    else if (on_gesture)
        steer(scene, &told);
    else
        of_engine(scene, &told);
}

int messages_perform(carom *scene, const char *text, double time) {
    message from;
    scene->told[0] = 0;
    if (setjmp(scene->refused)) return 0;
    if (!isfinite(time)) refuse(scene, "at = %g: expected a time in s", time);
    split(scene, &from, text);
    if (!from.count || from.words[0].kind != A_TEXT || from.words[0].text[0] != '/')
        refuse(scene, "expected an address, which starts with /");
    perform(scene, from.words[0].text, &from, from.words + 1, from.count - 1, time);
    return 1;
}

void messages_begin(carom *scene) {
    scene->object_count = scene->gesture_count = 0;
    scene->made = scene->ends_read = scene->mode = scene->serial = 0;
    scene->slot = -1;
    scene->gesture_number = LIVE;
    for (const value *each = part(scene, "objects")->first; each; each = each->next) {
        object made = {.said = each, .preset = item_at(part(scene, "presets"), (long)number_of(each, "preset"))};
        made.slot = (int64_t)number_of(each, "slot");
        made.serial = (int64_t)number_of(each, "serial");
        int64_t end = laid(scene, &made, "layout.first") + laid(scene, &made, "layout.size");
        if (made.serial > scene->serial) scene->serial = made.serial;
        if (made.slot > scene->slot) scene->slot = made.slot;
        if (end > scene->mode) scene->mode = end;
        if (scene->object_count == scene->object_room || strlen(each->key) >= LONGEST_NAME) continue;
        strcpy(made.name, each->key);
        scene->objects[scene->object_count++] = made;
    }
}
