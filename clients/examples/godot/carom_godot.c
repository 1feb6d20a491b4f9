/* Carom in Godot 4: a scene that Carom has exported is an AudioStream, which takes the contacts of a game.

   Godot calls `carom_godot_init`, which registers two classes: CaromStream, which scripts use, and CaromPlayback, which
   Godot's audio thread asks for sound. */
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "carom.h"
#include "interface.h"

#define MEMBER(result, name, arguments) result (*name) arguments;
#define NAME(result, name, arguments) #name,
static struct { FUNCTIONS(MEMBER) } godot;
static const char *const names[] = {FUNCTIONS(NAME)};
static void *library;

/* A value of any type, and a Variant, which takes 24 bytes. */
typedef union {
    int64_t whole;
    double real;
    float floats[4];
    uint8_t flag;
    void *words[5];
} value;

static void *name_of(const char *text) {
    void *name = NULL;
    godot.string_name_new_with_latin1_chars(&name, text, 1);
    return name; /* static: Godot keeps it */
}

static void free_value(int type, void *of) {
    void (*end)(void *) = godot.variant_get_ptr_destructor(type); /* NULL where there is nothing to free */
    if (end) end(of);
}

/* An opened scene. A stream and all that play it hold it; the last one closes it. */
typedef struct {
    carom *scene;
    atomic_int holders;
} opened;

typedef struct {
    opened *of; /* NULL: none yet */
    int plays, channels;
} instance; /* of either class */

static void let_go(opened *of) {
    if (!of || atomic_fetch_sub(&of->holders, 1) > 1) return;
    carom_close(of->scene);
    free(of);
}

/* The methods of CaromStream: `values` and `result` are as a table below says. */
static carom *scene_of(const instance *self) {
    return self->of ? self->of->scene : NULL;
}

static void put_string(void *result, const char *text) {
    free_value(STRING, result);
    godot.string_new_with_utf8_chars(result, text);
}

static char *text_of(const void *string) {
    int64_t size = godot.string_to_utf8_chars(string, NULL, 0);
    char *text = calloc((size_t)size + 1, 1);
    if (text) godot.string_to_utf8_chars(string, text, size);
    return text;
}

static int64_t whole(const void *of) {
    return *(const int64_t *)of;
}

static float real(const void *of) {
    return (float)*(const double *)of;
}

static void open_scene(instance *self, const void *const *values, void *result) {
    void *size_name = name_of("size");
    int64_t size = 0;
    godot.variant_get_ptr_builtin_method(BYTES, &size_name, size_hash)(values[0], NULL, &size, 0);
    const void *baked = size ? godot.packed_byte_array_operator_index_const(values[0], 0) : NULL;
    carom *scene = carom_open(size ? baked : "", (size_t)size, 1);
    opened *made = scene ? calloc(1, sizeof *made) : NULL;
    *(uint8_t *)result = made != NULL;
    if (!made) {
        if (scene) carom_close(scene);
        return;
    }
    made->scene = scene;
    atomic_init(&made->holders, 1);
    let_go(self->of);
    self->of = made;
}

static void answer(instance *self, const void *const *values, void *result) {
    put_string(result, carom_answer(scene_of(self)));
}

static void rate(instance *self, const void *const *values, void *result) {
    *(double *)result = scene_of(self) ? carom_rate(scene_of(self)) : 0.0;
}

static void send(instance *self, const void *const *values, void *result) {
    char *text = text_of(values[0]);
    *(uint8_t *)result = scene_of(self) && text && carom_send(scene_of(self), text, -1.0);
    free(text);
}

static void body(instance *self, const void *const *values, void *result) {
    char *text = text_of(values[0]);
    *(int64_t *)result = scene_of(self) && text ? carom_body(scene_of(self), text) : -1;
    free(text);
}

static void move(instance *self, const void *const *values, void *result) {
    const float *told = values[2], turn[4] = {told[3], told[0], told[1], told[2]}; /* Godot has w last */
    carom *scene = scene_of(self);
    *(uint8_t *)result = scene && carom_move(scene, (int)whole(values[0]), values[1], turn, values[3], values[4]);
}

static void touch(instance *self, const void *const *values, void *result) {
    carom *scene = scene_of(self);
    const int a = (int)whole(values[0]), b = (int)whole(values[1]);
    const float impulse = real(values[4]), speed = real(values[5]), slip = real(values[6]);
    *(uint8_t *)result = scene && carom_touch(scene, a, b, values[2], values[3], impulse, speed, slip);
}

static void frame(instance *self, const void *const *values, void *result) {
    *(uint8_t *)result = scene_of(self) && carom_frame(scene_of(self), *(const double *)values[0]);
}

static void listen(instance *self, const void *const *values, void *result) {
    *(uint8_t *)result = scene_of(self) && carom_listen(scene_of(self), values[0], values[1]);
}

static void govern(instance *self, const void *const *values, void *result) {
    *(uint8_t *)result = scene_of(self) && carom_govern(scene_of(self), *(const double *)values[0]);
}

static void put_count(void *dictionary, const char *name, double count) {
    value string = {0}, key = {0}, number = {.real = count};
    godot.string_new_with_utf8_chars(&string, name);
    godot.get_variant_from_type_constructor(STRING)(&key, &string);
    godot.get_variant_from_type_constructor(FLOAT)(godot.dictionary_operator_index(dictionary, &key), &number);
    godot.variant_destroy(&key);
    free_value(STRING, &string);
}

static void report(instance *self, const void *const *values, void *result) {
    free_value(DICTIONARY, result);
    godot.variant_get_ptr_constructor(DICTIONARY, 0)(result, NULL);
    if (!scene_of(self)) return;
    carom_contacts told;
    carom_report_contacts(scene_of(self), &told);
    const struct {
        const char *name;
        double count;
    } counts[] = {
        {"blows", (double)told.blows}, {"faint", (double)told.faint}, {"slides", (double)told.slides},
        {"left_out", (double)told.left_out}, {"loudest", told.loudest}, {"crowded", (double)told.crowded},
        {"bodies", (double)told.bodies},
    };
    for (size_t n = 0; n < sizeof counts / sizeof *counts; n++) put_count(result, counts[n].name, counts[n].count);
}

enum { MOST_ARGUMENTS = 7 };

typedef struct {
    const char *name;
    void (*run)(instance *self, const void *const *values, void *result);
    enum type result;
    int count;
    enum type types[MOST_ARGUMENTS];
    const char *names[MOST_ARGUMENTS];
} method;

static method methods[] = {
    {"open", open_scene, BOOL, 1, {BYTES}, {"baked"}},
    {"answer", answer, STRING, 0, {0}, {0}},
    {"rate", rate, FLOAT, 0, {0}, {0}},
    {"send", send, BOOL, 1, {STRING}, {"message"}},
    {"body", body, INT, 1, {STRING}, {"name"}},
    {"move", move, BOOL, 5, {INT, VECTOR3, QUATERNION, VECTOR3, VECTOR3},
     {"body", "position", "turn", "velocity", "spin"}},
    {"touch", touch, BOOL, 7, {INT, INT, VECTOR3, VECTOR3, FLOAT, FLOAT, FLOAT},
     {"a", "b", "point", "normal", "impulse", "speed", "slip"}},
    {"frame", frame, BOOL, 1, {FLOAT}, {"seconds"}},
    {"listen", listen, BOOL, 2, {VECTOR3, VECTOR3}, {"position", "right"}},
    {"govern", govern, BOOL, 1, {FLOAT}, {"share"}},
    {"report", report, DICTIONARY, 0, {0}, {0}},
};

/* As a script calls that knows the types. */
static void call_typed(void *told, void *self, const void *const *values, void *result) {
    ((const method *)told)->run(self, values, result);
}

/* As a script calls with variants. */
static void call(void *told, void *self, const void *const *variants, int64_t count, void *result, call_error *error) {
    const method *of = told;
    if (count != of->count) {
        *error = (call_error){count < of->count ? TOO_FEW : TOO_MANY, 0, of->count};
        return;
    }
    for (int n = 0; n < of->count; n++) {
        int type = godot.variant_get_type(variants[n]);
        if (type == (int)of->types[n] || (type == INT && of->types[n] == FLOAT)) continue;
        *error = (call_error){WRONG_ARGUMENT, n, (int)of->types[n]};
        return;
    }
    value values[MOST_ARGUMENTS] = {{0}}, made = {0};
    const void *told_values[MOST_ARGUMENTS];
    for (int n = 0; n < of->count; n++) {
        godot.get_variant_to_type_constructor((int)of->types[n])(&values[n], (void *)variants[n]);
        told_values[n] = &values[n];
    }
    godot.variant_get_ptr_constructor((int)of->result, 0)(&made, NULL);
    of->run(self, told_values, &made);
    godot.get_variant_from_type_constructor((int)of->result)(result, &made);
    free_value((int)of->result, &made);
    for (int n = 0; n < of->count; n++) free_value((int)of->types[n], &values[n]);
}

/* The virtual methods of both classes. */
enum { STREAM, PLAYBACK };
static const char *const class_names[] = {"CaromStream", "CaromPlayback"};
static const char *const parents[] = {"AudioStream", "AudioStreamPlayback"};

static void *make(intptr_t which, opened *of) {
    void *name = name_of(class_names[which]), *parent = name_of(parents[which]);
    instance *self = calloc(1, sizeof *self);
    void *object = self ? godot.classdb_construct_object(&parent) : NULL;
    if (!object) return NULL;
    self->of = of;
    if (of) {
        atomic_fetch_add(&of->holders, 1);
        self->channels = carom_channels(of->scene);
    }
    godot.object_set_instance(object, &name, self);
    return object;
}

static void *create(void *told) {
    return make((intptr_t)told, NULL);
}

static void free_instance(void *told, void *self) {
    let_go(((instance *)self)->of);
    free(self);
}

static void instantiate(void *self, const void *const *values, void *result) {
    godot.ref_set_object(result, make(PLAYBACK, ((instance *)self)->of));
}

static void start(void *self, const void *const *values, void *result) {
    ((instance *)self)->plays = 1;
}

static void stop(void *self, const void *const *values, void *result) {
    ((instance *)self)->plays = 0;
}

static void is_playing(void *self, const void *const *values, void *result) {
    *(uint8_t *)result = (uint8_t)((instance *)self)->plays;
}

static void playback_position(void *self, const void *const *values, void *result) {
    *(double *)result = 0.0; /* a game has no end, either */
}

/* On the audio thread: a buffer of pairs left and right, how fast (passed over), and how many frames. */
static void mix(void *self, const void *const *values, void *result) {
    const instance *own = self;
    float *out = *(float *const *)values[0];
    int64_t frames = *(int64_t *)result = whole(values[2]);
    if (!own->of || !own->plays) {
        memset(out, 0, (size_t)frames * 2 * sizeof *out);
        return;
    }
    carom_process(own->of->scene, out, (size_t)frames);
    for (int64_t n = own->channels == 1 ? frames - 1 : -1; n >= 0; n--) out[2 * n] = out[2 * n + 1] = out[n];
}

static struct {
    const char *name;
    void (*run)(void *self, const void *const *values, void *result);
} virtuals[] = {
    {"_instantiate_playback", instantiate}, {"_start", start}, {"_stop", stop},
    {"_is_playing", is_playing}, {"_get_playback_position", playback_position}, {"_mix", mix},
};

/* Names of one text are one pointer. */
static void *find_virtual(void *told, const void *name) {
    for (size_t n = 0; n < sizeof virtuals / sizeof *virtuals; n++)
        if (*(void *const *)name == name_of(virtuals[n].name)) return (void *)virtuals[n].run;
    return NULL;
}

static void add_method(void *class_name, method *of) {
    void *empty = name_of(""), *name = name_of(of->name), *called[MOST_ARGUMENTS];
    value hint = {0};
    godot.string_new_with_utf8_chars(&hint, "");
    property arguments[MOST_ARGUMENTS], result = {of->result, &empty, &empty, 0, &hint, USUAL_PROPERTY};
    int kinds[MOST_ARGUMENTS] = {0};
    for (int n = 0; n < of->count; n++) {
        called[n] = name_of(of->names[n]);
        arguments[n] = (property){of->types[n], &called[n], &empty, 0, &hint, USUAL_PROPERTY};
    }
    const method_info info = {
        .name = &name, .told = of, .call = call, .call_typed = call_typed, .flags = PLAIN_METHOD, .returns = 1,
        .result = &result, .count = (uint32_t)of->count, .arguments = arguments, .kinds = kinds,
    };
    godot.classdb_register_extension_class_method(library, &class_name, &info);
    free_value(STRING, &hint);
}

static void begin(void *told, int level) {
    if (level != SCENE_LEVEL) return;
    for (intptr_t which = STREAM; which <= PLAYBACK; which++) {
        void *name = name_of(class_names[which]), *parent = name_of(parents[which]);
        const class_info info = {
            .is_exposed = 1, .create = create, .free = free_instance, .find_virtual = find_virtual,
            .told = (void *)which,
        };
        godot.classdb_register_extension_class2(library, &name, &parent, &info);
        for (size_t n = 0; which == STREAM && n < sizeof methods / sizeof *methods; n++) add_method(name, &methods[n]);
    }
}

static void end(void *told, int level) {
    for (int which = PLAYBACK; level == SCENE_LEVEL && which >= STREAM; which--) {
        void *name = name_of(class_names[which]);
        godot.classdb_unregister_extension_class(library, &name);
    }
}

#ifdef _WIN32
__declspec(dllexport)
#else
__attribute__((visibility("default")))
#endif
uint8_t carom_godot_init(void *(*find)(const char *name), void *own, initialization *made) {
    for (size_t n = 0; n < sizeof names / sizeof *names; n++) {
        void *found = find(names[n]);
        if (!found) return 0; /* a Godot before 4.2 */
        memcpy((char *)&godot + n * sizeof found, &found, sizeof found);
    }
    library = own;
    *made = (initialization){SCENE_LEVEL, NULL, begin, end};
    return 1;
}
