/* Macros: those of the body are settings that the engine follows by a table; the others change values of gestures. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "messages.h"

enum { MACRO, MOST, POWER, LOW, HIGH }; /* of a law in the rules */
enum { SETTING, OF_BODY };              /* of a macro in the rules */

static int number_of_macro(const carom *scene, const char *name) {
    int number = 0;
    for (const value *each = part(scene, "macros")->first; each; each = each->next, number++)
        if (!strcmp(each->key, name)) return number < MOST_MACROS ? number : 0;
    return 0;
}

double macro_of(const carom *scene, const object *of, const value *law) {
    return law->kind == LIST ? of->macros[number_of_macro(scene, item_at(law, MACRO)->text)] : NEUTRAL;
}

double lawful(const value *law, double base, double place) {
    double most = item_at(law, MOST)->number;
    if (most > 0.0) return base * pow(pow(most, 2.0 * (place - NEUTRAL)), item_at(law, POWER)->number);
    return place < NEUTRAL ? base * place / NEUTRAL : base + (1.0 - base) * (place / NEUTRAL - 1.0);
}

double fitted(const value *law, double number) {
    return number == 0.0 ? number : fmin(fmax(number, item_at(law, LOW)->number), item_at(law, HIGH)->number);
}

/* The stiffness of a ball against an object, of another material by its macro: of Hertz, as material.py has it. */
double stiffness_of(const carom *scene, const object *of, const value *striker, double own) {
    const value *touched = item(item(of->said, "macros"), "touched");
    double modulus = number_of(striker, "modulus"), radius = number_of(striker, "radius");
    long steps = -1;
    for (const value *each = touched->first; each; each = each->next) steps++;
    long step = lrint((double)steps * of->macros[number_of_macro(scene, "material")]);
    if (!(modulus > 0.0) || steps < 1 || 2 * step == steps) return own;
    return 4.0 / 3.0 / (1.0 / modulus + item_at(touched, step)->number) / sqrt(1.0 / radius);
}

/* The factor of an object's mass by its macros. */
double heavier(const carom *scene, const object *of) {
    double octaves = 0.0;
    const value *axis = item(item(of->said, "macros"), "amplitudes")->first;
    for (const value *each = part(scene, "macros")->first; each && axis; each = each->next) {
        if (item_at(each, OF_BODY)->number == 0.0) continue;
        long nodes = 0;
        for (const value *node = axis->first; node; node = node->next) nodes++;
        double place = of->macros[number_of_macro(scene, each->key)] * (double)(nodes - 1);
        long node = place < (double)(nodes - 2) ? (long)place : nodes - 2;
        double share = place - (double)node;
        octaves += (1.0 - share) * item_at(axis, node)->number + share * item_at(axis, node + 1)->number;
        axis = axis->next;
    }
    return octaves == 0.0 ? 1.0 : pow(4.0, -octaves);
}

static void reshape(carom *scene, object *of, double time) {
    const call told = {.time = time};
    command made;
    if (of->reshaped) return;
    begin(scene, &made, &told, "RESHAPE");
    about(scene, &made, of);
    set(scene, &made, "value", number_of(item(of->said, "macros"), "table"));
    send_command(scene, &made);
    of->reshaped = 1;
}

/* Bring an object that was made to the macros that it has from another one. */
void turn_like(carom *scene, object *made, double time) {
    const call told = {.time = time};
    made->reshaped = 0;
    for (const value *each = part(scene, "macros")->first; each; each = each->next) {
        double place = made->macros[number_of_macro(scene, each->key)];
        command sent;
        if (place == NEUTRAL) continue;
        if (item_at(each, OF_BODY)->number != 0.0) reshape(scene, made, time);
        begin(scene, &sent, &told, "SET");
        about(scene, &sent, made);
        set(scene, &sent, "parameter", item_at(each, SETTING)->number);
        set(scene, &sent, "value", place);
        send_command(scene, &sent);
    }
}

/* Steer the gestures on an object that go on, as they follow a macro. */
static void steer_running(carom *scene, const call *told, const object *of, const char *name) {
    point found[64];
    int count = points(scene, told->verb, told->from, told->words, told->count, found, 64);
    collect(scene);
    for (int n = 0; n < scene->gesture_count; n++) {
        const running *each = &scene->gestures[n];
        int is_newest = 1;
        for (int k = n + 1; k < scene->gesture_count; k++) is_newest &= scene->gestures[k].number != each->number;
        if (!is_newest || strcmp(each->target, of->name)) continue;
        for (int k = 0; k < each->followed_count; k++) {
            const value *law = each->followed[k].law;
            if (strcmp(item_at(law, MACRO)->text, name)) continue;
            command made;
            begin(scene, &made, told, "STEER");
            set(scene, &made, "gesture", (double)each->number);
            set(scene, &made, "follows", 1.0);
            set(scene, &made, "parameter", number_of(part(scene, "steerable"), law->key));
            double after = 0.0;
            for (int p = 0; p < count; p++) {
                double over = found[p].over > 0.0 ? found[p].over : number_of(scene->rules, "glide");
                set(scene, &made, "value", fitted(law, lawful(law, each->followed[k].base, found[p].value)));
                set(scene, &made, "ramp.after", after);
                set(scene, &made, "ramp.over", over);
                set(scene, &made, "ramp.curve", found[p].curve);
                send_command(scene, &made);
                after += found[p].over;
            }
        }
    }
}

static void turn_one(carom *scene, const call *told, object *of, const char *name, const value *macro) {
    int is_of_body = item_at(macro, OF_BODY)->number != 0.0;
    command made;
    if (is_of_body) reshape(scene, of, told->time);
    begin(scene, &made, told, "SET");
    about(scene, &made, of);
    set(scene, &made, "parameter", item_at(macro, SETTING)->number);
    of->macros[number_of_macro(scene, name)] = send_points(scene, &made, told);
    if (!is_of_body) steer_running(scene, told, of, name);
}

/* Turn a macro of an object, and of the copies for its notes. */
void turn(carom *scene, const call *told, object *of) {
    const char *name = told->action + strlen("macro/");
    const value *macro = item(part(scene, "macros"), name);
    size_t size = strlen(of->name);
    if (item_at(macro, OF_BODY)->number != 0.0) {
        if (item(of->said, "macros")->kind != MAP)
            refuse(scene, "%s of %.80s: this export has no table of it; expected a plug-in, an export of one object, or a score that turns it",
                   name, of->name);
        if (of->change[0] != 0.0 || of->change[1] != 0.0 || of->change[2] != 0.0)
            refuse(scene, "%s of %.80s: it was made live in another size or material; expected an object of the score", name, of->name);
    }
    for (int n = 0; n < scene->object_count; n++) {
        object *each = &scene->objects[n];
        if (each->pitch > 0.0 && each->said == of->said && !strncmp(each->name, of->name, size) && each->name[size] == '.')
            turn_one(scene, told, each, name, macro);
    }
    turn_one(scene, told, of, name, macro);
}
