/* What the adapter takes of Godot's interface for extensions, which is the same from Godot 4.2 on. Vectors have floats,
   as in the builds that Godot's makers give out. */
#ifndef CAROM_GODOT_INTERFACE_H
#define CAROM_GODOT_INTERFACE_H

#include <stdint.h>

enum type { BOOL = 1, INT, FLOAT, STRING, VECTOR3 = 9, QUATERNION = 15, DICTIONARY = 27, BYTES = 29 };
enum { WRONG_ARGUMENT = 2, TOO_MANY, TOO_FEW };               /* errors of a call */
enum { SCENE_LEVEL = 2, PLAIN_METHOD = 1, USUAL_PROPERTY = 6 }; /* when classes are registered; flags */
static const int64_t size_hash = 3173160232; /* of a method that takes nothing, changes nothing, and returns an int */

typedef struct {
    enum type type;
    void *name, *class_name;
    uint32_t hint;
    void *hint_text;
    uint32_t usage;
} property;

typedef struct {
    int error, argument, expected;
} call_error;

typedef struct {
    void *name, *told;
    void (*call)(void *told, void *self, const void *const *variants, int64_t count, void *result, call_error *error);
    void (*call_typed)(void *told, void *self, const void *const *values, void *result);
    uint32_t flags;
    uint8_t returns;
    property *result;
    int result_kind;
    uint32_t count;
    property *arguments;
    int *kinds;
    uint32_t defaults_count;
    void **defaults;
} method_info;

typedef struct {
    uint8_t is_virtual, is_abstract, is_exposed;
    void *unused[11]; /* properties, notifications, references */
    void *(*create)(void *told);
    void (*free)(void *told, void *self);
    void *recreate;
    void *(*find_virtual)(void *told, const void *name);
    void *virtual_data, *call_virtual, *rid, *told;
} class_info;

typedef struct {
    int first_level;
    void *told;
    void (*begin)(void *told, int level), (*end)(void *told, int level);
} initialization;

typedef void (*convert)(void *into, void *from);
typedef void (*construct)(void *into, const void *const *from);
typedef void (*destruct)(void *value);
typedef void (*builtin)(const void *self, const void *const *values, void *result, int count);

/* Results, names and arguments of functions; names of classes and methods are pointers to StringNames. */
#define FUNCTIONS(F) \
    F(void, string_name_new_with_latin1_chars, (void *name, const char *text, uint8_t is_static)) \
    F(void, string_new_with_utf8_chars, (void *string, const char *text)) \
    F(int64_t, string_to_utf8_chars, (const void *string, char *text, int64_t most)) \
    F(convert, get_variant_from_type_constructor, (int type)) \
    F(convert, get_variant_to_type_constructor, (int type)) \
    F(int, variant_get_type, (const void *variant)) \
    F(void, variant_destroy, (void *variant)) \
    F(construct, variant_get_ptr_constructor, (int type, int32_t number)) \
    F(destruct, variant_get_ptr_destructor, (int type)) \
    F(builtin, variant_get_ptr_builtin_method, (int type, const void *name, int64_t hash)) \
    F(const uint8_t *, packed_byte_array_operator_index_const, (const void *bytes, int64_t index)) \
    F(void *, dictionary_operator_index, (void *dictionary, const void *key)) \
    F(void, ref_set_object, (void *ref, void *object)) \
    F(void *, classdb_construct_object, (const void *class_name)) \
    F(void, object_set_instance, (void *object, const void *class_name, void *self)) \
    F(void, classdb_register_extension_class2, (void *own, const void *name, const void *of, const class_info *info)) \
    F(void, classdb_unregister_extension_class, (void *own, const void *name)) \
    F(void, classdb_register_extension_class_method, (void *own, const void *class_name, const method_info *info))

#endif
