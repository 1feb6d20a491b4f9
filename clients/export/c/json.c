/* JSON, as Carom writes it, and numbers of text. */
#include <locale.h>
#include <stdlib.h>
#include <string.h>

#include "inner.h"

enum { DEEPEST = 32, LONGEST = 64 };

static const value nothing = {NOTHING, NULL, NULL, 0.0, NULL, NULL};

typedef struct {
    char *at, *end;
    int depth;
} reader;

static value *read_value(reader *from);

double decimal(const char *text, const char **end) {
    char copy[LONGEST];
    const char *point = localeconv()->decimal_point;
    size_t n = 0, shift = strlen(point) - 1;
    for (; text[n] && strchr("+-.0123456789eE", text[n]); n++) {
    }
    if (n == 0 || n + shift >= LONGEST) {
        *end = text;
        return 0.0;
    }
    const char *dot = memchr(text, '.', n);
    size_t before = dot ? (size_t)(dot - text) : n;
    memcpy(copy, text, before);
    size_t length = before;
    if (dot) {
        memcpy(copy + before, point, shift + 1);
        memcpy(copy + before + shift + 1, dot + 1, n - before - 1);
        length = n + shift;
    }
    copy[length] = 0;
    char *stop;
    double number = strtod(copy, &stop);
    size_t used = (size_t)(stop - copy);
    *end = text + (dot && used > before ? used - shift : used);
    return number;
}

static void skip(reader *from) {
    while (from->at < from->end && strchr(" \t\r\n", *from->at) && *from->at) from->at++;
}

static int hex(const char *at) {
    int code = 0;
    for (int n = 0; n < 4; n++) {
        const char *digits = "0123456789abcdef";
        char c = at[n] >= 'A' && at[n] <= 'F' ? (char)(at[n] + 32) : at[n];
        const char *found = c ? strchr(digits, c) : NULL;
        if (!found) return -1;
        code = 16 * code + (int)(found - digits);
    }
    return code;
}

static char *put_code(char *to, long code) {
    if (code < 0x80) {
        *to++ = (char)code;
    } else if (code < 0x800) {
        *to++ = (char)(0xC0 | code >> 6);
        *to++ = (char)(0x80 | (code & 0x3F));
    } else if (code < 0x10000) {
        *to++ = (char)(0xE0 | code >> 12);
        *to++ = (char)(0x80 | (code >> 6 & 0x3F));
        *to++ = (char)(0x80 | (code & 0x3F));
    } else {
        *to++ = (char)(0xF0 | code >> 18);
        *to++ = (char)(0x80 | (code >> 12 & 0x3F));
        *to++ = (char)(0x80 | (code >> 6 & 0x3F));
        *to++ = (char)(0x80 | (code & 0x3F));
    }
    return to;
}

/* Read a text behind its first quote, in place. NULL if it is not closed. */
static char *read_text(reader *from) {
    char *begin = from->at, *to = begin;
    while (from->at < from->end && *from->at != '"') {
        char c = *from->at++;
        if (c != '\\') {
            *to++ = c;
            continue;
        }
        if (from->at >= from->end) return NULL;
        c = *from->at++;
        const char *named = "\"\\/bfnrt", *found = c ? strchr(named, c) : NULL;
        if (found) {
            *to++ = "\"\\/\b\f\n\r\t"[found - named];
            continue;
        }
        if (c != 'u' || from->end - from->at < 4) return NULL;
        long code = hex(from->at);
        from->at += 4;
        if (code >= 0xD800 && code < 0xDC00 && from->end - from->at >= 6 && from->at[0] == '\\') {
            long low = hex(from->at + 2);
            from->at += 6;
            code = 0x10000 + ((code - 0xD800) << 10) + (low - 0xDC00);
        }
        if (code < 0) return NULL;
        to = put_code(to, code);
    }
    if (from->at >= from->end) return NULL;
    from->at++;
    *to = 0;
    return begin;
}

/* Read what a list or a map holds. 0 if it is not closed, or what is between is no JSON. */
static int read_items(reader *from, value *into) {
    char close = into->kind == MAP ? '}' : ']';
    value **last = &into->first;
    for (;;) {
        skip(from);
        if (from->at >= from->end) return 0;
        if (*from->at == close && !into->first) break;
        const char *key = NULL;
        if (into->kind == MAP) {
            if (*from->at++ != '"' || !(key = read_text(from))) return 0;
            skip(from);
            if (from->at >= from->end || *from->at++ != ':') return 0;
        }
        value *made = read_value(from);
        if (!made) return 0;
        made->key = key;
        *last = made;
        last = &made->next;
        skip(from);
        if (from->at >= from->end) return 0;
        if (*from->at == close) break;
        if (*from->at++ != ',') return 0;
    }
    from->at++;
    return 1;
}

static int read_word(reader *from, value *into) {
    static const struct {
        const char *word;
        int kind;
        double number;
    } words[] = {{"true", TRUTH, 1.0}, {"false", TRUTH, 0.0}, {"null", NOTHING, 0.0}};
    for (int n = 0; n < 3; n++) {
        size_t size = strlen(words[n].word);
        if ((size_t)(from->end - from->at) >= size && !memcmp(from->at, words[n].word, size)) {
            into->kind = words[n].kind;
            into->number = words[n].number;
            from->at += size;
            return 1;
        }
    }
    const char *end;
    into->kind = NUMBER;
    into->number = decimal(from->at, &end);
    int read = end > from->at;
    from->at += end - from->at;
    return read;
}

static value *read_value(reader *from) {
    skip(from);
    if (from->at >= from->end || from->depth >= DEEPEST) return NULL;
    value *made = calloc(1, sizeof *made);
    if (!made) return NULL;
    int whole;
    from->depth++;
    if (*from->at == '{' || *from->at == '[') {
        made->kind = *from->at++ == '{' ? MAP : LIST;
        whole = read_items(from, made);
    } else if (*from->at == '"') {
        from->at++;
        made->kind = TEXT;
        made->text = read_text(from);
        whole = made->text != NULL;
    } else {
        whole = read_word(from, made);
    }
    from->depth--;
    if (whole) return made;
    json_free(made);
    return NULL;
}

value *json_read(char *text, size_t size) {
    reader from = {text, text + size, 0};
    return read_value(&from);
}

void json_free(value *root) {
    while (root) {
        value *next = root->next;
        json_free(root->first);
        free(root);
        root = next;
    }
}

const value *item(const value *map, const char *key) {
    for (const value *each = map->first; each && map->kind == MAP; each = each->next)
        if (!strcmp(each->key, key)) return each;
    return &nothing;
}

const value *item_at(const value *list, long place) {
    const value *each = list->first;
    while (each && place-- > 0) each = each->next;
    return each ? each : &nothing;
}

const value *item_of(const value *map, const char *prefix, const char *key) {
    size_t size = strlen(prefix);
    for (const value *each = map->first; each && map->kind == MAP; each = each->next)
        if (!strncmp(each->key, prefix, size) && !strcmp(each->key + size, key)) return each;
    return &nothing;
}

int place_of(const value *list, const char *text) {
    int place = 0;
    for (const value *each = list->first; each; each = each->next, place++)
        if (each->kind == TEXT && !strcmp(each->text, text)) return place;
    return -1;
}

double number_of(const value *map, const char *key) {
    return item(map, key)->number;
}

const char *text_of(const value *map, const char *key) {
    const char *text = item(map, key)->text;
    return text ? text : "";
}

int is_true(const value *map, const char *key) {
    return item(map, key)->number != 0.0;
}
