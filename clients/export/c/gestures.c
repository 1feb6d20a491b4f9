/* Gestures: a message, completed by what the object's preset says, as a command. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "messages.h"

#define GRAVITY 9.80665
#define APPROACH 0.01   /* m/s: how fast a pressing striker is laid on */
#define ANY_RADIUS 0.01 /* m: of a roll that is steered, and so has one; of an object where it touches another */

/* A gesture's message, with what the object's preset says of what it leaves out. */
typedef struct {
    table given, defaults;
    const value *gesture, *preset, *surface, *striker;
    const object *of, *by;
    double mass, stiffness, dissipation, exponent, restitution, position;
    double base_mass, base_stiffness; /* in the middle of the macro `hardness` */
    table motion;
} begun;

static double given_or(const begun *to, const char *name, double otherwise) {
    const named *found = entry(&to->given, name);
    if (!found) found = entry(&to->defaults, name);
    return found ? found->number : otherwise;
}

static int is_given(const begun *to, const char *name) {
    return entry(&to->given, name) != NULL;
}

static void complete(carom *scene, const call *told, begun *to) {
    parse(scene, told->address, told->verb, told->words, told->count, &to->given, &to->defaults);
    const char *argument = text_of(to->gesture, "argument");
    const char *instead = text_of(to->gesture, "instead");
    if (is_given(to, instead) && is_given(to, argument))
        refuse(scene, "%s, %s: expected one of the two", argument, instead);
    const value *usual = item(item(to->preset, "usual"), told->action);
    int strikes = is_given(to, "striker") || is_given(to, "by") || (is_given(to, "mass") && is_given(to, "stiffness"));
    if (usual->kind == MAP) {
        const char *surface = text_of(usual, "surface");
        if (*surface && !is_given(to, "surface")) put_text(scene, &to->given, "surface", surface);
        if (!strikes) put_text(scene, &to->given, "striker", text_of(usual, "striker"));
        for (const value *each = item(usual, "numbers")->first; each; each = each->next)
            if (!strikes || !strcmp(each->key, argument)) put(scene, &to->defaults, each->key, each->number);
    } else if (!strcmp(argument, "velocity")) {
        put(scene, &to->defaults, "velocity", number_of(to->preset, "velocity"));
    }
    if (is_given(to, instead)) put(scene, &to->defaults, argument, 0.0);
    if (!is_given(to, argument) && !entry(&to->defaults, argument))
        refuse(scene, "%s is missing, and %s has none", argument, text_of(to->preset, "name"));
}

static const object *striking(carom *scene, const begun *to) {
    const named *name = entry(&to->given, "by");
    if (!name) return NULL;
    const object *by = object_by(scene, name->text);
    if (!by || by == to->of) refuse(scene, "by = %.80s: expected another object", name->text);
    return by;
}

static const value *named_part(carom *scene, const char *what, const char *all, const char *name) {
    const value *found = item(part(scene, all), name);
    if (found->kind != MAP) refuse_all(scene, what, name, part(scene, all)->first);
    return found;
}

/* Find the contact law of a gesture: its striker's, or that of two materials, and the values that are given. */
static void find_law(carom *scene, begun *to, double radius) {
    const value *presets = part(scene, "presets");
    long own = (long)number_of(to->of->said, "preset");
    const value *law = item_at(item(to->striker, "laws"), own);
    double *parts[] = {&to->mass, &to->stiffness, &to->dissipation, &to->exponent, &to->restitution};
    static const char *const names[] = {"mass", "stiffness", "dissipation", "exponent", "restitution"};
    for (int n = 0; n < 5; n++) *parts[n] = item_at(law, n)->number;
    to->stiffness = stiffness_of(scene, to->of, to->striker, to->stiffness);
    if (to->by) to->mass = number_of(to->by->said, "mass") * heavier(scene, to->by);
    if (radius > 0.0) {
        const value *touching =
            item_at(item(item_at(presets, own), "touching"), (long)number_of(to->by->said, "preset"));
        to->stiffness = item_at(touching, 0)->number * sqrt(radius);
        to->dissipation = item_at(touching, 1)->number;
        to->exponent = item_at(touching, 2)->number;
        to->restitution = 0.0;
    }
    if (to->surface) {
        if (is_given(to, "restitution")) refuse(scene, "restitution: expected dissipation, along a surface");
        to->dissipation = number_of(to->surface, "dissipation");
        to->restitution = 0.0;
    }
    if (is_given(to, "dissipation") && is_given(to, "restitution"))
        refuse(scene, "dissipation, restitution: expected one of the two");
    if (is_given(to, "dissipation")) to->restitution = 0.0;
    for (int n = 0; n < 5; n++)
        if (is_given(to, names[n])) *parts[n] = entry(&to->given, names[n])->number;
    to->base_mass = to->mass, to->base_stiffness = to->stiffness;
    for (int n = 0; n < 2 && !to->by; n++) {
        const value *of = item(item(to->gesture, "laws"), names[n]);
        double place = macro_of(scene, to->of, of);
        if (place != NEUTRAL) *parts[n] = fitted(of, lawful(of, *parts[n], place));
    }
}

/* A number that a table has, to be changed; NULL: it has none of that name. */
static double *number_in(table *from, const char *name) {
    const named *found = entry(from, name);
    return found ? &from->entries[found - from->entries].number : NULL;
}

/* Change the values of a gesture as the object's macros have them, but the contact law. */
static void turn_values(carom *scene, begun *to, table *bases) {
    to->position = is_given(to, "position") ? given_or(to, "position", 0.0) : number_of(to->preset, "position");
    put(scene, bases, "position", to->position);
    for (const value *law = item(to->gesture, "laws")->first; law; law = law->next) {
        if (!strcmp(law->key, "stiffness") || !strcmp(law->key, "mass")) continue;
        double place = macro_of(scene, to->of, law);
        double *numbers[] = {number_in(&to->given, law->key), number_in(&to->defaults, law->key)};
        if (strcmp(law->key, "position") && (numbers[0] || numbers[1]))
            put(scene, bases, law->key, numbers[0] ? *numbers[0] : *numbers[1]);
        for (int n = 0; n < 2; n++)
            if (numbers[n] && place != NEUTRAL) *numbers[n] = fitted(law, lawful(law, *numbers[n], place));
        if (!strcmp(law->key, "position") && place != NEUTRAL) to->position = fitted(law, lawful(law, to->position, place));
    }
}

/* Remember what macros change of a gesture that goes on. */
static void follow(const begun *to, running *as, const table *bases) {
    for (const value *name = item(to->gesture, "steerable")->first; name; name = name->next) {
        const value *law = item(item(to->gesture, "laws"), name->text);
        const named *base = entry(bases, name->text);
        int is_law = !strcmp(name->text, "stiffness") || !strcmp(name->text, "mass");
        if (law->kind != LIST || as->followed_count == MOST_FOLLOWED || (is_law ? to->by != NULL : !base)) continue;
        as->followed[as->followed_count].law = law;
        as->followed[as->followed_count++].base =
            base ? base->number : strcmp(name->text, "mass") ? to->base_stiffness : to->base_mass;
    }
}

/* Of a striker that falls: the velocity at which it meets the object, and when. */
static void fall(carom *scene, begun *to) {
    double height = given_or(to, "height", 0.0), thrown = given_or(to, "velocity", 0.0);
    double gravity = given_or(to, "gravity", GRAVITY), velocity = sqrt(thrown * thrown + 2.0 * gravity * height);
    put(scene, &to->motion, "velocity", velocity);
    put(scene, &to->motion, "delay", thrown > 0.0 ? 2.0 * height / (velocity + thrown) : (velocity - thrown) / gravity);
}

static void slip(carom *scene, begun *to, const call *told, double radius, table *bases) {
    const value *sliding = radius > 0.0 ? part(scene, "dry") : item(to->striker, "sliding");
    for (const value *each = sliding->first; each; each = each->next) {
        double own = radius > 0.0 && !strcmp(each->key, "radius") ? radius : each->number;
        put(scene, &to->motion, each->key, given_or(to, each->key, own));
    }
    const value *law = item(item(to->gesture, "laws"), "force");
    double weight = to->mass * GRAVITY, place = macro_of(scene, to->of, law);
    if (!entry(bases, "force")) put(scene, bases, "force", weight);
    put(scene, &to->motion, "force", given_or(to, "force", place == NEUTRAL ? weight : lawful(law, weight, place)));
    const named *most = entry(&to->motion, "static"), *moving = entry(&to->motion, "dynamic");
    if (most && moving && moving->number > most->number)
        refuse(scene, "dynamic = %g: expected at most static = %g", moving->number, most->number);
    const named *press = entry(&to->given, "press");
    if (!press) return;
    if (!goes_on(scene, press->text, told->target, "press"))
        refuse(scene, "press = %.80s: expected the id of a press on %.80s that goes on", press->text, told->target);
    put(scene, &to->motion, "press", (double)running_by(scene, press->text)->number);
}

static void find_motion(carom *scene, begun *to) {
    const char *argument = text_of(to->gesture, "argument");
    to->motion.count = 0;
    for (const value *each = item(to->gesture, "own")->first; each; each = each->next)
        put(scene, &to->motion, each->text, given_or(to, each->text, 0.0));
    if (!is_true(to->gesture, "falls")) put(scene, &to->motion, argument, given_or(to, argument, 0.0));
    if (is_true(to->gesture, "held")) put(scene, &to->motion, "velocity", APPROACH);
    if (is_true(to->gesture, "falls")) fall(scene, to);
}

/* Find the radius of what rolls, and the least that a surface takes. */
static void find_radius(carom *scene, begun *to, double radius, int moves, int continued, const table *bases) {
    const named *told = entry(&to->given, "radius") ? entry(&to->given, "radius") : entry(&to->defaults, "radius");
    if (is_true(to->gesture, "rolls")) {
        double found = told ? told->number : radius > 0.0 ? radius : number_of(to->striker, "radius");
        if (!(found > 0.0) && moves && !continued)
            refuse(scene, "radius is missing: the striker is no ball; expected its radius (m)");
        put(scene, &to->motion, "radius", found > 0.0 ? found : ANY_RADIUS);
    }
    if (to->surface && moves && !continued) {
        const named *own = entry(&to->motion, "radius"), *rough = entry(bases, "roughness");
        double once = number_of(to->surface, "least"), least = once * (rough ? rough->number : NAN);
        double *felt = number_in(&to->motion, "roughness");
        if (own && own->number < least)
            refuse(scene, "radius = %g: expected at least %g m on this surface", own->number, least);
        if (own && felt && once > 0.0) *felt = fmin(*felt, own->number / once);
    }
}

/* Write the values of a gesture into its command: what it has usually, how it moves, its law, and where. */
static void write_values(carom *scene, command *made, const begun *to) {
    const value *sound = item(to->striker, is_true(to->gesture, "slips") ? "held" : "sound");
    int is_point = !is_given(to, "striker") && is_given(to, "mass") && is_given(to, "stiffness");
    int is_silent = to->by || is_point || is_true(to->gesture, "drops");
    static const value in_db = {TEXT, "unit", "dB", 0.0, NULL, NULL};
    const value gain = {MAP, NULL, NULL, 0.0, (value *)&in_db, NULL};
    double by_position = to->by ? number_of(to->by->preset, "position") : 0.0;
    const struct {
        const char *name;
        double number;
    } more[] = {
        {"sound", is_silent ? 0.0 : item_at(sound, 0)->number},
        {"sound_serial", is_silent ? 0.0 : item_at(sound, 1)->number},
        {"mass", to->mass},
        {"stiffness", to->stiffness},
        {"dissipation", to->dissipation},
        {"exponent", to->exponent},
        {"restitution", to->restitution},
        {"position", to->position},
        {"gain", in_engine(&gain, given_or(to, "gain", 0.0))},
        {"by_position", is_given(to, "by_position") ? given_or(to, "by_position", 0.0) : by_position},
    };
    for (const value *each = item(to->gesture, "values")->first; each; each = each->next)
        field_write(scene, made->bytes, "values.", each->key, each->number);
    for (int n = 0; n < to->motion.count; n++)
        field_write(scene, made->bytes, "values.", to->motion.entries[n].name, to->motion.entries[n].number);
    for (size_t n = 0; n < sizeof more / sizeof *more; n++)
        field_write(scene, made->bytes, "values.", more[n].name, more[n].number);
}

/* Write what a gesture along a surface has besides: which values were given, and the surface's profile. */
static void write_along(carom *scene, command *made, const begun *to) {
    const value *steerable = part(scene, "steerable"), *profile = item(to->surface, "profile");
    double bits = 0.0;
    for (const value *each = item(to->gesture, "steerable")->first; each; each = each->next)
        if (is_given(to, each->text)) bits += ldexp(1.0, (int)number_of(steerable, each->text));
    set(scene, made, "given", bits);
    int place = 0;
    const value *fields = item(part(scene, "command"), "fields");
    for (const value *each = fields->first; each; each = each->next)
        if (!strncmp(each->key, "surface.", 8)) set(scene, made, each->key, item_at(profile, place++)->number);
}

/* Find the table of a swarm's blows. */
static void find_pulses(carom *scene, begun *to) {
    double exponent = is_true(to->gesture, "drops") ? 0.0 : to->exponent;
    if (to->by) refuse(scene, "by = %.80s: grains hit it; expected a striker", to->by->name);
    for (const value *each = part(scene, "pulses")->first; each; each = each->next) {
        if (item_at(each, 0)->number != exponent) continue;
        put(scene, &to->motion, "pulses", item_at(each, 1)->number);
        return;
    }
    refuse(scene, "exponent = %g: expected a gesture of small blows with it in the scene's score",
           exponent);
}

/* Begin a gesture, or steer the one along a surface that goes on with its id. */
void gesture(carom *scene, const call *told, const object *of) {
    begun to = {.of = of, .preset = of->preset, .gesture = item(part(scene, "gestures"), told->action)};
    int along = is_true(to.gesture, "along");
    collect(scene);
    complete(scene, told, &to);
    table bases = {.count = 0};
    turn_values(scene, &to, &bases);
    to.by = striking(scene, &to);
    const named *name = entry(&to.given, "striker");
    to.striker = named_part(scene, "striker", "strikers", name ? name->text : text_of(to.preset, "striker"));
    const named *surface = entry(&to.given, "surface");
    if (along) to.surface = named_part(scene, "surface", "surfaces", surface ? surface->text : "wood");
    const named *radius = entry(&to.given, "by_radius") ? entry(&to.given, "by_radius") : entry(&to.given, "radius");
    double touching = to.by && !name ? (radius ? radius->number : ANY_RADIUS) : 0.0; /* by materials */
    find_law(scene, &to, touching);
    find_motion(scene, &to);
    const char *moving = is_true(to.gesture, "falls") ? "velocity" : text_of(to.gesture, "argument");
    double instead = given_or(&to, text_of(to.gesture, "instead"), 0.0), most = number_of(to.gesture, "most") * to.mass;
    if (instead > most) refuse(scene, "impulse = %g: expected at most %g N s of a striker of %g kg", instead, most, to.mass);
    int moves = entry(&to.motion, moving)->number > 0.0 || instead > 0.0;
    if (!moves && !is_true(to.gesture, "lasts")) return;
    if (is_true(to.gesture, "swarms")) find_pulses(scene, &to);

    char own[LONGEST_NAME] = "";
    const named *given = entry(&to.given, "id");
    const char *id = given ? given->text : along ? told->target : own;
    if (!given && !along && !is_true(to.gesture, "single"))
        snprintf(own, sizeof own, "%.200s-%lld", told->target, (long long)++scene->made);
    int continued = along && goes_on(scene, id, told->target, told->action);
    if (is_true(to.gesture, "slips")) slip(scene, &to, told, touching, &bases);
    find_radius(scene, &to, touching, moves, continued, &bases);
    int64_t number = *id ? start(scene, id, told->target, told->action) : 0;
    if (number) follow(&to, &scene->gestures[scene->gesture_count - 1], &bases);
    if (is_true(to.gesture, "seeded"))
        put(scene, &to.motion, "seed", is_given(&to, "seed") ? entry(&to.given, "seed")->number : (double)number);

    command made;
    begin(scene, &made, told, "GESTURE");
    about(scene, &made, of);
    set(scene, &made, "what", number_of(to.gesture, "number"));
    set(scene, &made, "gesture", (double)number);
    if (to.by) {
        set(scene, &made, "by_slot", (double)to.by->slot);
        set(scene, &made, "by_serial", (double)to.by->serial);
    }
    write_values(scene, &made, &to);
    if (along) write_along(scene, &made, &to);
    send_command(scene, &made);
    snprintf(scene->told, sizeof scene->told, "%s", id);
}
