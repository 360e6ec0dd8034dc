/* scene_doc.h - a document being read: places in it, what stands there, and what is wrong there.
 *
 * Private to the scene reader. scene_json.c alone knows the JSON library and answers the
 * scene_at_* questions; scene_doc.c keeps the faults and reads single values; scene_read.c and
 * scene_shape.c know the format. A place borrows its parents and the parsed tree: it lives no
 * longer than the call of scene_parse that made it.
 *
 * Readers return whether the value was good; when it was not they have recorded a fault, and the
 * output is untouched. They go on after a fault, so that a document's faults come all at once.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_SCENE_DOC_H
#define COMMON_SCENE_DOC_H

#include "common/scene.h"

enum scene_type {
    SCENE_NULL,
    SCENE_BOOLEAN,
    SCENE_NUMBER,
    SCENE_STRING,
    SCENE_ARRAY,
    SCENE_OBJECT
};

struct scene_at {
    const struct scene_at *up; /* the array or object that holds it; NULL: the whole document */
    const char *key;           /* its name in that object; NULL in an array */
    size_t index;              /* its number in there, in document order */
    void *node;                /* the JSON library's value, borrowed */
};

enum { SCENE_MAX_FAULTS = 100 };

struct scene_fault {
    uint32_t order[SCENE_MAX_DEPTH + 1]; /* indices from the root down: the place as a sort key */
    uint32_t depth;
    struct scene_error error;
};

struct scene_doc {
    enum scene_source source;
    bool rescale; /* scene_share.h */
    struct arena *arena;                         /* the scene's and its errors' memory */
    struct scene_fault faults[SCENE_MAX_FAULTS]; /* the first ones in document order, sorted */
    size_t kept, total;
};

/* What stands at a place (scene_json.c). */
enum scene_type scene_at_type(const struct scene_at *);
double scene_at_number(const struct scene_at *);      /* SCENE_NUMBER; never -0 */
bool scene_at_boolean(const struct scene_at *);       /* SCENE_BOOLEAN */
const char *scene_at_string(const struct scene_at *); /* SCENE_STRING; valid UTF-8 */
size_t scene_at_count(const struct scene_at *);       /* SCENE_ARRAY, SCENE_OBJECT */
struct scene_at scene_at_item(const struct scene_at *array, size_t index);
bool scene_at_member(const struct scene_at *object, const char *key, struct scene_at *member);
bool scene_at_next(const struct scene_at *object, struct scene_at *member); /* first: node NULL */

/* Records a fault; always returns false. */
bool scene_doc_fault(struct scene_doc *, const struct scene_at *, enum err_code, const char *fmt,
                     ...) PRINTF(4, 5);
/* Whether a fault here would still be among those that are kept: a costly text is then due. */
bool scene_doc_listed(const struct scene_doc *, const struct scene_at *);
/* "expected EXPECTED, got (the value, cut when long)"; always returns false. */
bool scene_doc_expected(struct scene_doc *, const struct scene_at *, enum err_code,
                        const char *expected);
/* The place as a JSON pointer, in the document's arena. */
const char *scene_doc_pointer(struct scene_doc *, const struct scene_at *);
/* A string of the document for a message: in quotes, cut when long, harmless on a terminal. */
enum { SCENE_QUOTE_BYTES = 320 };
void scene_doc_quote(const char *, char out[SCENE_QUOTE_BYTES]);
/* Sorted faults to the caller's list; the last of too many says how many there are besides. */
void scene_doc_report(const struct scene_doc *, struct scene_errors *);

struct scene_key {
    const char *name;
    bool required;
};

/* An object with these keys and no others; `what` names it in messages: "a sphere". */
bool scene_doc_object(struct scene_doc *, const struct scene_at *, const char *what,
                      const struct scene_key *keys, size_t count);

/* Closed, finite. Above a `limit` the document is too large (ERR_LIMIT) rather than wrong. */
struct scene_range {
    double lo, hi;
    bool limit;
};

bool scene_doc_number(struct scene_doc *, const struct scene_at *, struct scene_range, double *);
bool scene_doc_integer(struct scene_doc *, const struct scene_at *, struct scene_range, uint64_t *);
bool scene_doc_numbers(struct scene_doc *, const struct scene_at *, struct scene_range, double *out,
                       size_t count);
bool scene_doc_rgb(struct scene_doc *, const struct scene_at *, struct scene_range, rgb *);
bool scene_doc_array(struct scene_doc *, const struct scene_at *, const char *of, size_t min_count,
                     size_t max_count);
bool scene_doc_text(struct scene_doc *, const struct scene_at *, size_t min_bytes, size_t max_bytes,
                    const char **);
bool scene_doc_choice(struct scene_doc *, const struct scene_at *, const char *const *names,
                      size_t count, size_t *chosen);
/* The key "type" of an object, by which its other keys are known. */
bool scene_doc_kind(struct scene_doc *, const struct scene_at *, const char *what,
                    const char *const *names, size_t count, size_t *kind);

/* The same for the value of a key. Absent: true, and the output keeps its default; that a
 * required key is absent has been said by scene_doc_object. */
bool scene_key_number(struct scene_doc *, const struct scene_at *object, const char *key,
                      struct scene_range, double *);
bool scene_key_integer(struct scene_doc *, const struct scene_at *object, const char *key,
                       struct scene_range, uint64_t *);
bool scene_key_numbers(struct scene_doc *, const struct scene_at *object, const char *key,
                       struct scene_range, double *out, size_t count);
bool scene_key_rgb(struct scene_doc *, const struct scene_at *object, const char *key,
                   struct scene_range, rgb *);

/* The nearest of the names when it is near enough to be meant, else NULL (scene_suggest.c). */
const char *scene_suggest(const char *name, const char *const *names, size_t count);

#endif
