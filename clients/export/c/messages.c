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

/* Send a command for each point, or none where there is no room for all; the last value. */
double send_points(carom *scene, command *made, const call *told) {
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
    return found[count - 1].value;
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
    begun->followed_count = 0;
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

void add_object(carom *scene, object made, const char *name) {
    name_into(scene, made.name, name);
    scene->objects[scene->object_count++] = made;
}

static void remove_object(carom *scene, object *gone) {
    scene->object_count--;
    memmove(gone, gone + 1, (size_t)(scene->objects + scene->object_count - gone) * sizeof *gone);
}

/* The sample up to which the engine has come. */
static int64_t position(const carom *scene) {
    return whole_at(scene, scene->position);
}

/* Leave the place of an object that is freed at a time to others, if it was made live. */
void leave_place(carom *scene, const object *gone, double time) {
    double now = (double)position(scene);
    if (gone->modes)
        scene->freed[scene->freed_count++] =
            (vacancy){gone->slot, gone->first, gone->modes, (int64_t)fmax(now, time) + 2 * (int64_t)number_of(scene->rules, "quantum"),
                    scene->inbox_written, -1};
}

/* True if the engine has all commands to an object that was freed, and it is gone. */
static int is_left(const carom *scene, vacancy *left) {
    const value *state = part(scene, "state");
    if (left->taken < 0 && __atomic_load_n(&scene->inbox_read, __ATOMIC_ACQUIRE) >= left->sent)
        left->taken = whole_at(scene, scene->written);
    if (left->taken < 0 || whole_at(scene, scene->read) < left->taken || position(scene) < left->until) return 0;
    int64_t slots = (int64_t)number_of(state, "slots") + (int64_t)number_of(state, "used");
    return !whole_at(scene, slots + left->slot * (int64_t)number_of(state, "object"));
}

/* Find a place for an object of so many modes: one that was left, the tightest, or a new one. */
static void find_place(carom *scene, object *made, int64_t modes) {
    const value *state = part(scene, "state");
    int found = -1;
    for (int n = 0; n < scene->freed_count; n++) {
        vacancy *each = &scene->freed[n];
        int tighter = found < 0 || each->modes < scene->freed[found].modes;
        if (each->modes >= modes && tighter && is_left(scene, each)) found = n;
    }
    made->serial = scene->serial + 1;
    if (found >= 0) {
        const vacancy *left = &scene->freed[found];
        made->slot = left->slot, made->first = left->first, made->modes = left->modes;
        scene->freed[found] = scene->freed[--scene->freed_count];
        return;
    }
    if (scene->mode + modes > (int64_t)number_of(state, "modes") || scene->slot + 1 >= scene->object_room)
        refuse(scene, "no capacity for another object: %d of %d, %lld of %lld modes", (int)scene->slot + 1,
               scene->object_room, (long long)scene->mode, (long long)number_of(state, "modes"));
    made->slot = ++scene->slot, made->first = scene->mode, made->modes = modes;
    scene->mode += modes;
}

/* Make an object of another's modes, with settings by their names; a plate's copies do not stretch. */
static void copy(carom *scene, const object *of, object *made, const char *name, const table *settings, double time) {
    int64_t next = __atomic_load_n(&scene->next, __ATOMIC_ACQUIRE);
    if (!scene->live && (int64_t)number_of(of->said, "batch") >= next)
        refuse(scene, "%.80s: its object is not there yet", name);
    if (scene->object_count == scene->object_room) refuse(scene, "no capacity for another object");
    if (room(scene) < MOST_MACROS + 2) refuse(scene, "no capacity for another command: %lld wait", (long long)scene->ring);
    command sent;
    memcpy(sent.bytes, scene->data + (int64_t)number_of(of->said, "made"), (size_t)scene->command_size);
    find_place(scene, made, laid(scene, of, "layout.size"));
    about(scene, &sent, made);
    set(scene, &sent, "time", time);
    const value *materials = part(scene, "materials");
    const value *own = item(materials, text_of(of->preset, "material")), *other = made->material ? made->material : own;
    double changes[11] = {made->change[0], made->change[1], made->change[2]};
    for (int n = 0; n < 4; n++) {
        changes[3 + n] = item_at(own, 2 + n)->number;
        changes[7 + n] = item_at(other, 2 + n)->number;
    }
    int copied = carom_engine_copy(scene->state, sent.bytes, made->first, changes) > 0;
    for (const value *each = part(scene, "settings")->first; copied && each; each = each->next) {
        int at = (int)each->number;
        const named *given = settings ? entry(settings, each->key) : NULL;
        if (given) made->settings[at] = given->number, made->given |= 1u << at;
        if (!(made->given >> at & 1)) continue;
        const value *declared = item_at(item(item_of(part(scene, "verbs"), "/object/NAME/", each->key), "required"), 0);
        field_write(scene, sent.bytes, "settings.", each->key, in_engine(declared, made->settings[at]));
    }
    if (!copied) leave_place(scene, made, -1.0);
    if (!copied) refuse(scene, "%.80s: no object can be so", name);
    if (made->pitch > 0.0) set(scene, &sent, "settings.tune", made->pitch);
    send_command(scene, &sent);
    scene->serial++;
    turn_like(scene, made, time);
    add_object(scene, *made, name);
}

/* Make an object, and its body, in another's image. */
void make(carom *scene, const call *told) {
    table given, defaults;
    parse(scene, told->address, told->verb, told->words, told->count, &given, &defaults);
    const char *name = entry(&given, "name")->text, *like = entry(&given, "like")->text;
    const named *size = entry(&given, "size"), *material = entry(&given, "material");
    const object *of = object_by(scene, like);
    if (!of) refuse_all(scene, "object", like, part(scene, "objects")->first);
    if (object_by(scene, name)) refuse(scene, "%.80s: there is an object of that name", name);
    if (carom_body(scene, name) >= 0) refuse(scene, "%.80s: there is a silent body of that name", name);
    if (name[strcspn(name, " #*,/?[]{}")] || strlen(name) >= LONGEST_NAME)
        refuse(scene, "name = %.80s: expected no blank, none of #*,/?[]{}, and at most 255 bytes", name);
    object made = *of;
    made.pitch = 0.0;
    for (int n = 0; n < MOST_MACROS; n++) made.macros[n] = NEUTRAL;
    if (size) made.change[0] += log2(size->number);
    if (!(fabs(made.change[0]) <= 10.0)) refuse(scene, "size = %g: expected up to 1024 times the score's object", size->number);
    int64_t number = -1;
    if (material) {
        const value *materials = part(scene, "materials"), *own = item(materials, text_of(of->preset, "material"));
        made.material = item(materials, material->text);
        if (made.material->kind != LIST) refuse_all(scene, "material", material->text, materials->first);
        if (own->kind != LIST) refuse(scene, "%.80s: it has no material", like);
        double denser = item_at(made.material, 1)->number / item_at(own, 1)->number;
        made.change[1] = 0.5 * log2(item_at(made.material, 0)->number / item_at(own, 0)->number / denser);
        made.change[2] = log2(denser);
    }
    for (const value *each = part(scene, "materials")->first; made.material && each && each != made.material; each = each->next) number++;
    made.body = -1;
    const value *row = item(part(scene, "bodies"), of->said->key);
    int has_body = of->body >= 0 && row->kind == LIST;
    copy(scene, of, &made, name, &given, told->time);
    if (has_body) scene->objects[scene->object_count - 1].body = body_like(scene, row, &made, made.material ? number + 1 : -1);
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
    if (!object_by(scene, name)) {
        object made = *of;
        double pitch = number_of(of->said, "pitch");
        if (!(pitch > 0.0)) refuse(scene, "note: it has no audible mode, and so no pitch");
        made.pitch = 440.0 * pow(2.0, (number->number - 69.0) / 12.0) / pitch;
        made.body = -1;
        copy(scene, of, &made, name, NULL, told->time);
    }
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
    if (!strncmp(told->action, "macro/", 6)) {
        turn(scene, told, of);
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
    leave_place(scene, of, told->time);
    body_gone(scene, of->body);
    remove_object(scene, of);
}

/* The two parts of an address /GROUP/TARGET/ACTION; 0: it has others. */
static int parts_of(const char *address, const char *group, char *target, const char **action) {
    size_t size = strlen(group);
    if (strncmp(address, group, size)) return 0;
    const char *slash = strchr(address + size, '/');
    if (!slash || (strchr(slash + 1, '/') && strncmp(slash, "/macro/", 7)) || slash - address - size >= LONGEST_NAME) return 0;
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
    else if (!strcmp(address, "/object/new"))
        make(scene, &told);
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
    scene->freed_count = 0;
    scene->made = scene->ends_read = scene->mode = scene->serial = 0;
    scene->slot = -1;
    scene->gesture_number = LIVE;
    for (const value *each = part(scene, "objects")->first; each; each = each->next) {
        object made = {.said = each, .preset = item_at(part(scene, "presets"), (long)number_of(each, "preset"))};
        made.slot = (int64_t)number_of(each, "slot");
        made.serial = (int64_t)number_of(each, "serial");
        made.body = -1;
        for (int n = 0; n < MOST_MACROS; n++) made.macros[n] = NEUTRAL;
        int64_t end = laid(scene, &made, "layout.first") + laid(scene, &made, "layout.size");
        if (made.serial > scene->serial) scene->serial = made.serial;
        if (made.slot > scene->slot) scene->slot = made.slot;
        if (end > scene->mode) scene->mode = end;
        if (scene->object_count == scene->object_room || strlen(each->key) >= LONGEST_NAME) continue;
        strcpy(made.name, each->key);
        scene->objects[scene->object_count++] = made;
    }
    bodies_begin(scene);
}
