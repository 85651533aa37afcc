/* A client of Maniple in one file, in C99 with POSIX sockets. It speaks JSON lines.
 *
 *     cc -O2 -ffp-contract=off -o maniple-c maniple.c -lm
 *     ./maniple-c HOST PORT [TOKEN] [--match=NUMBER] [--conformance]
 *
 * As a program it plays one seat: it sends its units straight to their zone, and who is stopped steps aside. For a bot of
 * your own include it, write three functions, and play:
 *
 *     #define MANIPLE_NO_MAIN
 *     #include "maniple.c"
 *
 *     static void on_cycle(View *view, void *mine) {
 *         for (size_t i = 0; i < view->count; i++)
 *             if (view->objects[i].owner == view->seat)
 *                 order_move(view, view->objects[i].handle, 10.0, 20.0);
 *     }
 *
 * What is on the wire is told in docs/PROTOCOL.md; numbers of sections in this file are those of that document. Without
 * -ffp-contract=off a compiler may fuse a multiplication with an addition, and positions differ from the server's. */

#define _POSIX_C_SOURCE 200809L

#include <errno.h>
#include <math.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

#ifndef MSG_NOSIGNAL
#define MSG_NOSIGNAL 0
#endif

enum {
    PROTOCOL = 3,
    MESSAGE_MAX = 16384,  /* bytes of a message to the server */
    ORDER_MAX = 6144,     /* bytes of one command: a path of 64 waypoints fits */
    READ_ROOM = 65536,    /* bytes of a message from the server for which there is room at first */
    NESTING_MAX = 64,     /* of a message; the deepest of the server has about ten */
    RECONNECTS_MAX = 3,   /* times that a connection which breaks without a reason is opened again */
};

static void fail(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    fputs("maniple.c: ", stderr);
    vfprintf(stderr, format, arguments);
    fputc('\n', stderr);
    va_end(arguments);
    exit(1);
}

static void *resized(void *memory, size_t bytes) {
    void *larger = realloc(memory, bytes ? bytes : 1);
    if (!larger) fail("out of memory");
    return larger;
}

/* --- JSON. A message is read in place into a tree: texts point into the line, and values live as long as it does. */

typedef enum { NOTHING, BOOL, NUMBER, TEXT, LIST, OBJECT } Kind;

typedef struct Value {
    Kind kind;
    double number;        /* of a bool 0 or 1 */
    char *text;
    char *key;            /* where it is a field of an object */
    struct Value *first;  /* of a list or an object */
    struct Value *next;   /* within a list or an object */
} Value;

enum { BLOCK_VALUES = 4096 };

typedef struct Block {
    struct Block *next;
    size_t used;
    Value values[BLOCK_VALUES];
} Block;

/* A line and the values in it. */
typedef struct {
    char *line;
    Block *blocks;
    char *at;
    int depth;
} Message;

static void forget(Message *message) {
    while (message->blocks) {
        Block *next = message->blocks->next;
        free(message->blocks);
        message->blocks = next;
    }
    free(message->line);
    *message = (Message){0};
}

static Value *new_value(Message *message, Kind kind) {
    Block *block = message->blocks;
    if (!block || block->used == BLOCK_VALUES) {
        block = resized(NULL, sizeof *block);
        block->next = message->blocks;
        block->used = 0;
        message->blocks = block;
    }
    Value *value = &block->values[block->used++];
    *value = (Value){.kind = kind};
    return value;
}

static char next_character(Message *message) {
    while (strchr(" \t\r\n", *message->at) && *message->at) message->at++;
    return *message->at;
}

static void expect(Message *message, const char *word) {
    next_character(message);
    if (strncmp(message->at, word, strlen(word)) != 0) fail("the server sent no JSON: at `%.20s`", message->at);
    message->at += strlen(word);
}

/* Writes a character of the basic plane as UTF-8. Names of players are all that can have others: they get a `?`. */
static char *put_character(char *to, unsigned long code) {
    if (code < 0x80) {
        *to++ = (char)code;
    } else if (code < 0x800) {
        *to++ = (char)(0xc0 | code >> 6);
        *to++ = (char)(0x80 | (code & 0x3f));
    } else if (code >= 0xd800 && code < 0xe000) {
        *to++ = '?';
    } else {
        *to++ = (char)(0xe0 | code >> 12);
        *to++ = (char)(0x80 | (code >> 6 & 0x3f));
        *to++ = (char)(0x80 | (code & 0x3f));
    }
    return to;
}

/* Reads a text; without its escapes it is never longer, so it is written over itself. */
static char *read_text(Message *message) {
    expect(message, "\"");
    char *start = message->at, *to = start;
    while (*message->at && *message->at != '"') {
        if (*message->at != '\\') {
            *to++ = *message->at++;
            continue;
        }
        char escape = *++message->at;
        static const char escapes[] = "bfnrt", meanings[] = "\b\f\n\r\t";
        const char *found = escape ? strchr(escapes, escape) : NULL;
        if (escape == 'u' && strlen(message->at) > 4) {
            char digits[5] = {0};
            memcpy(digits, message->at + 1, 4);
            to = put_character(to, strtoul(digits, NULL, 16));
            message->at += 4;
        } else {
            *to++ = found ? meanings[found - escapes] : escape;
        }
        if (*message->at) message->at++;
    }
    expect(message, "\"");
    *to = 0;
    return start;
}

static Value *read_value(Message *message);

static Value *read_members(Message *message, Kind kind, char end) {
    Value *value = new_value(message, kind), **last = &value->first;
    if (++message->depth > NESTING_MAX) fail("the server sent JSON that is nested too deeply");
    message->at++;
    while (next_character(message) != end) {
        if (value->first) expect(message, ",");
        next_character(message);
        char *key = kind == OBJECT ? read_text(message) : NULL;
        if (key) expect(message, ":");
        *last = read_value(message);
        (*last)->key = key;
        last = &(*last)->next;
    }
    message->at++;
    message->depth--;
    return value;
}

static Value *read_value(Message *message) {
    Value *value;
    switch (next_character(message)) {
    case '{':
        return read_members(message, OBJECT, '}');
    case '[':
        return read_members(message, LIST, ']');
    case '"':
        value = new_value(message, TEXT);
        value->text = read_text(message);
        return value;
    case 'n':
        expect(message, "null");
        return new_value(message, NOTHING);
    case 't':
        expect(message, "true");
        value = new_value(message, BOOL);
        value->number = 1;
        return value;
    case 'f':
        expect(message, "false");
        return new_value(message, BOOL);
    default: {
        char *end;
        value = new_value(message, NUMBER);
        value->number = strtod(message->at, &end);
        if (end == message->at) fail("the server sent no JSON: at `%.20s`", message->at);
        message->at = end;
        return value;
    }
    }
}

/* Returns a field that may be missing: NULL then, and where `object` is none. */
static const Value *find(const Value *object, const char *key) {
    const Value *each = object->kind == OBJECT ? object->first : NULL;
    while (each && strcmp(each->key, key) != 0) each = each->next;
    return each;
}

static const Value *field(const Value *object, const char *key) {
    const Value *found = find(object, key);
    if (!found) fail("the server sent a message without `%s`", key);
    return found;
}

static const Value *item(const Value *list, uint32_t place) {
    const Value *each = list->first;
    while (each && place--) each = each->next;
    if (!each) fail("the server sent a list that is too short");
    return each;
}

/* Returns a whole number; all ones where it is null, as the check of section 8 counts what is none. */
static uint32_t whole(const Value *value) {
    return value->kind == NOTHING ? UINT32_MAX : (uint32_t)value->number;
}

static uint32_t whole_field(const Value *object, const char *key) {
    return whole(field(object, key));
}

static int is_text(const Value *value, const char *text) {
    return value->kind == TEXT && strcmp(value->text, text) == 0;
}

#define EACH(each, list) (const Value *each = (list)->first; each; each = each->next)

/* --- the hash of section 8: FNV-1a with 64 bits (Fowler, Noll and Vo, 1991) */

static const uint64_t FNV_START = 0xcbf29ce484222325u;

/* Hashes the lowest bytes of a number, little-endian. */
static uint64_t fnv(uint64_t hash, uint64_t number, int bytes) {
    for (int i = 0; i < bytes; i++) hash = (hash ^ (number >> 8 * i & 0xff)) * 0x100000001b3u;
    return hash;
}

static uint64_t fnv_double(uint64_t hash, double number) {
    uint64_t bits;
    memcpy(&bits, &number, sizeof bits);
    return fnv(hash, bits, 8);
}

/* --- what the player knows */

typedef struct {
    double x, y;
    uint32_t cycle;
    double fraction;
    double vx, vy;
} Base;

typedef struct {
    uint32_t hit_points, amount;  /* UINT32_MAX: none */
    int mode, action;             /* places in the lists below */
} Status;

typedef struct {
    uint32_t queued, load, ready, training, waiting, due;  /* training, due: UINT32_MAX: none */
    int task;
} Own;

typedef struct {
    uint32_t handle, unit_type;
    uint32_t owner;  /* UINT32_MAX: nobody */
    Base base;
    Status status;
    int is_own;
    Own own;         /* zero where it is not */
} Object;

static const char *const MODES[] = {"normal", "switching", "alternate", "switching_back", "site", NULL};
static const char *const ACTIONS[] = {"none", "gather", "build", NULL};
static const char *const TASKS[] = {"none", "attack", "attack_at", "attack_move", "hold", "gather", "return_load",
                                    "build", NULL};
enum { TASK_ATTACK_MOVE = 3 };

typedef struct {
    Message message;        /* of the welcome, which lies in it, and so do the rules */
    const Value *welcome;
    const Value *rules;     /* the rules of section 5: read them with `field`, `find`, `item` and EACH */
    uint32_t seat, width, height, cycle, stock;
    int is_lockstep;
    char *tiles;            /* row by row: tiles[y * width + x] */
    double (*walls)[4];
    size_t wall_count;
    unsigned char *visible; /* as tiles, 0 or 1; NULL without fog */
    Object *objects;        /* by handle */
    size_t count, capacity;
    const Value *delta;     /* the last one */
    uint64_t sum;           /* of all hashes of section 8 */
    char *out;              /* orders that wait to be sent, as messages */
    size_t out_length, out_message;  /* where the last message begins; 0: there is none */
    uint32_t next_seq;
} View;

static int place_of(const char *const *names, const Value *value) {
    for (int place = 0; names[place]; place++)
        if (is_text(value, names[place])) return place;
    fail("the server sent the name `%s`, which is not known", value->kind == TEXT ? value->text : "");
    return 0;
}

static Base base_of(const Value *value) {
    const Value *point = field(value, "point"), *velocity = find(value, "velocity");
    Base base = {item(point, 0)->number, item(point, 1)->number, whole_field(value, "cycle"),
                 field(value, "fraction")->number, 0.0, 0.0};
    if (velocity) {  /* who stopped has none */
        base.vx = item(velocity, 0)->number;
        base.vy = item(velocity, 1)->number;
    }
    return base;
}

static void set_status(Object *object, const Value *value) {
    if (value->kind == NOTHING) return;
    object->status = (Status){whole_field(value, "hit_points"), whole_field(value, "amount"),
                              place_of(MODES, field(value, "mode")), place_of(ACTIONS, field(value, "action"))};
}

static void set_own(Object *object, const Value *value) {
    if (value->kind == NOTHING) return;
    object->is_own = 1;
    object->own = (Own){whole_field(value, "queued"), whole_field(value, "load"), whole_field(value, "ready"),
                        whole_field(value, "training"), whole_field(value, "waiting"), whole_field(value, "due"),
                        place_of(TASKS, field(value, "task"))};
}

static uint64_t hash_of(const Object *object) {
    const Base *base = &object->base;
    uint64_t hash = fnv(fnv(fnv(FNV_START, object->handle, 4), object->unit_type, 2), object->owner, 2);
    hash = fnv(fnv_double(fnv_double(hash, base->x), base->y), base->cycle, 4);
    hash = fnv_double(fnv_double(fnv_double(hash, base->fraction), base->vx), base->vy);
    hash = fnv(fnv(hash, object->status.hit_points, 4), object->status.amount, 4);
    hash = fnv(fnv(hash, (uint64_t)object->status.mode, 1), (uint64_t)object->status.action, 1);
    if (!object->is_own) return hash;
    const Own *own = &object->own;
    hash = fnv(fnv(fnv(hash, own->queued, 4), (uint64_t)own->task, 1), own->load, 4);
    return fnv(fnv(fnv(fnv(hash, own->ready, 4), own->training, 2), own->waiting, 4), own->due, 4);
}

/* Returns the hash of the view. */
static uint64_t check_of(const View *view) {
    return fnv(fnv(fnv(FNV_START, view->cycle, 4), view->stock, 4), view->sum, 8);
}

/* Returns where an object is, or would be if it were there. */
static size_t place_of_handle(const View *view, uint32_t handle) {
    size_t low = 0, high = view->count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (view->objects[middle].handle < handle) low = middle + 1;
        else high = middle;
    }
    return low;
}

/* Returns an object; NULL where it is not in sight. */
static Object *object_of(const View *view, uint32_t handle) {
    size_t place = place_of_handle(view, handle);
    return place < view->count && view->objects[place].handle == handle ? &view->objects[place] : NULL;
}

/* Returns where an object is now: section 7, to the server's bits. */
static double x_of(const View *view, const Object *object) {
    return object->base.x + object->base.vx * (((double)view->cycle - (double)object->base.cycle) - object->base.fraction);
}

static double y_of(const View *view, const Object *object) {
    return object->base.y + object->base.vy * (((double)view->cycle - (double)object->base.cycle) - object->base.fraction);
}

static int is_moving(const Object *object) {
    return object->base.vx != 0.0 || object->base.vy != 0.0;
}

static const Value *type_of(const View *view, const Object *object) {
    return item(field(view->rules, "unit_types"), object->unit_type);
}

/* Returns an object that a delta changes, and takes its hash out of the sum. */
static Object *changing(View *view, uint32_t handle) {
    Object *object = object_of(view, handle);
    if (!object) fail("the delta of cycle %u changes object %u, which is not in the view", view->cycle, handle);
    view->sum -= hash_of(object);
    return object;
}

static void insert_object(View *view, const Value *appeared) {
    uint32_t handle = whole_field(appeared, "object");
    size_t place = place_of_handle(view, handle);
    if (view->count == view->capacity) {
        view->capacity = view->capacity * 2 + 64;
        view->objects = resized(view->objects, view->capacity * sizeof *view->objects);
    }
    Object *object = &view->objects[place];
    memmove(object + 1, object, (view->count++ - place) * sizeof *object);
    *object = (Object){.handle = handle, .unit_type = whole_field(appeared, "unit_type"),
                       .owner = whole_field(appeared, "owner"), .base = base_of(field(appeared, "base"))};
    set_status(object, field(appeared, "status"));
    set_own(object, field(appeared, "own"));
    view->sum += hash_of(object);
}

static void remove_objects(View *view, const Value *handles) {
    for EACH(each, handles) {
        Object *object = changing(view, whole(each));
        memmove(object, object + 1, (size_t)(view->objects + --view->count - object) * sizeof *object);
    }
}

static void add_wall(View *view, const Value *wall) {
    view->walls = resized(view->walls, (view->wall_count + 1) * sizeof *view->walls);
    double *to = view->walls[view->wall_count++];
    for EACH(each, wall) if (to < view->walls[view->wall_count - 1] + 4) *to++ = each->number;
}

static uint64_t hash_of_tile(uint32_t number, char tile) {
    return fnv(fnv(FNV_START, number, 4), (unsigned char)tile, 1);
}

static void apply_ground(View *view, const Value *delta) {
    uint64_t tiles = (uint64_t)view->width * view->height, at = 0;
    for EACH(run, field(delta, "sight")) {
        uint64_t first = at + whole(item(run, 0));
        at = first + whole(item(run, 1));
        if (!view->visible || at > tiles) fail("the server changes the sight of tiles that do not exist");
        for (uint64_t tile = first; tile < at; tile++) {
            uint64_t hash = hash_of_tile((uint32_t)tile, '*');
            view->sum += (view->visible[tile] ^= 1) ? hash : -hash;
        }
    }
    for EACH(run, field(delta, "revealed")) {
        uint64_t tile = (uint64_t)whole(item(run, 1)) * view->width + whole(item(run, 0));
        for (const char *each = item(run, 2)->text; *each; each++, tile++) {
            if (tile >= tiles) fail("the server reveals tiles that do not exist");
            view->tiles[tile] = *each;
            view->sum += hash_of_tile((uint32_t)tile, *each);
        }
    }
    for EACH(wall, field(delta, "walls")) {
        uint64_t hash = FNV_START;
        for EACH(each, wall) hash = fnv_double(hash, each->number);
        view->sum += hash;
        add_wall(view, wall);
    }
}

/* Changes the view by a delta, and compares its hash. */
static void apply(View *view, const Value *delta) {
    view->delta = delta;
    view->cycle = whole_field(delta, "cycle");
    if (field(delta, "stock")->kind != NOTHING) view->stock = whole_field(delta, "stock");
    apply_ground(view, delta);
    remove_objects(view, field(delta, "vanished"));
    remove_objects(view, field(delta, "died"));
    for EACH(moved, field(delta, "moved")) {
        Object *object = changing(view, whole_field(moved, "object"));
        object->base = base_of(field(moved, "base"));
        view->sum += hash_of(object);
    }
    for EACH(stopped, field(delta, "stopped")) {
        Object *object = changing(view, whole_field(stopped, "object"));
        object->base = base_of(stopped);
        view->sum += hash_of(object);
    }
    for EACH(changed, field(delta, "changed")) {
        Object *object = changing(view, whole_field(changed, "object"));
        set_status(object, field(changed, "status"));
        set_own(object, field(changed, "own"));
        view->sum += hash_of(object);
    }
    for EACH(appeared, field(delta, "appeared")) insert_object(view, appeared);
    const char *expected = field(delta, "check")->text;
    char found[17];
    snprintf(found, sizeof found, "%016llx", (unsigned long long)check_of(view));
    if (strcmp(found, expected) != 0)
        fail("after the delta of cycle %u the view hashes to %s, the server's to %s", view->cycle, found, expected);
}

static void begin(View *view, const Value *welcome) {
    const Value *terrain = field(welcome, "terrain");
    view->welcome = welcome;
    view->rules = field(welcome, "rules");
    view->seat = whole_field(welcome, "seat");
    view->cycle = whole_field(welcome, "cycle");
    view->is_lockstep = is_text(field(welcome, "clock"), "lockstep");
    view->width = whole_field(terrain, "width");
    view->height = whole_field(terrain, "height");
    size_t tiles = (size_t)view->width * view->height, at = 0;
    view->tiles = resized(NULL, tiles);
    for EACH(row, field(terrain, "tiles"))
        for (const char *tile = row->text; *tile && at < tiles; tile++) view->tiles[at++] = *tile;
    for EACH(wall, field(terrain, "segments")) add_wall(view, wall);
    if (field(view->rules, "fog")->number != 0.0) {
        view->visible = resized(NULL, tiles);
        memset(view->visible, 0, tiles);
    }
}

/* Starts anew: the next delta is a keyframe. */
static void begin_again(View *view) {
    free(view->tiles);
    free(view->walls);
    free(view->visible);
    view->walls = NULL;
    view->wall_count = view->count = 0;
    view->stock = 0;
    view->sum = 0;
    view->delta = NULL;
    view->tiles = NULL;
    view->visible = NULL;
    begin(view, view->welcome);
}

static void end(View *view) {
    forget(&view->message);
    free(view->tiles);
    free(view->walls);
    free(view->visible);
    free(view->objects);
    free(view->out);
    *view = (View){0};
}

/* --- orders. Each returns the number with which its result comes in `results` of the next delta. */

static void put(View *view, const char *text, size_t length) {
    view->out = resized(view->out, view->out_length + length);
    memcpy(view->out + view->out_length, text, length);
    view->out_length += length;
}

static void end_commands(View *view) {
    if (view->out_message) put(view, "]}}\n", 4);
    view->out_message = 0;
}

/* Gives any command of section 4, as JSON. */
static uint32_t order(View *view, const char *format, ...) {
    char text[ORDER_MAX], head[96];
    int length = snprintf(text, sizeof text, "{\"seq\":%u,\"command\":", view->next_seq);
    va_list arguments;
    va_start(arguments, format);
    length += vsnprintf(text + length, sizeof text - (size_t)length, format, arguments);
    va_end(arguments);
    if (length < 0 || (size_t)length + 2 > sizeof text) fail("an order is too long");
    text[length++] = '}';
    if (view->out_message && view->out_length - view->out_message + (size_t)length + 16 > MESSAGE_MAX) end_commands(view);
    if (!view->out_message) {
        int head_length = snprintf(head, sizeof head, "{\"commands\":{\"seen_cycle\":%u,\"list\":[", view->cycle);
        put(view, head, (size_t)head_length);
        view->out_message = view->out_length;
    } else {
        put(view, ",", 1);
    }
    put(view, text, (size_t)length);
    return view->next_seq++;
}

static uint32_t order_move(View *view, uint32_t handle, double x, double y) {
    return order(view, "{\"move\":{\"object\":%u,\"x\":%.17g,\"y\":%.17g}}", handle, x, y);
}

/* Goes to the first point, then to the second. */
static uint32_t order_path(View *view, uint32_t handle, const double first[2], const double second[2]) {
    return order(view, "{\"path\":{\"object\":%u,\"points\":[[%.17g,%.17g,null],[%.17g,%.17g,null]]}}", handle, first[0],
                 first[1], second[0], second[1]);
}

static uint32_t order_attack_move(View *view, uint32_t handle, double x, double y) {
    return order(view, "{\"attack_move\":{\"object\":%u,\"x\":%.17g,\"y\":%.17g}}", handle, x, y);
}

static uint32_t order_train(View *view, uint32_t handle, uint32_t unit_type) {
    return order(view, "{\"train\":{\"object\":%u,\"unit_type\":%u}}", handle, unit_type);
}

/* --- the connection */

/* A bot: functions that may be NULL, and what they keep. */
typedef struct {
    const char *name;
    void (*on_start)(View *view, void *mine);  /* the match begins, or goes on after the connection had broken */
    void (*on_cycle)(View *view, void *mine);  /* a cycle has passed: give orders */
    void (*on_end)(const Value *result, void *mine);
    void *mine;
} Bot;

typedef struct {
    const char *host, *port, *token;
    int conformance;  /* tell the server each check */
    const char *match;  /* its number, where the server has a lobby; else NULL */
} Login;

/* How a match ended. */
typedef struct {
    uint32_t seat, cycles, checks;  /* checks: how many times the two views agreed */
    char winners[256], hash[17];
} Outcome;

typedef struct {
    int socket;
    char *bytes;
    size_t length, capacity, scanned;
} Link;

static Link link_to(const Login *login) {
    struct addrinfo hints = {.ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM}, *found;
    int problem = getaddrinfo(login->host, login->port, &hints, &found);
    if (problem) fail("%s: %s", login->host, gai_strerror(problem));
    int socket_number = -1;
    for (struct addrinfo *each = found; each && socket_number < 0; each = each->ai_next) {
        socket_number = socket(each->ai_family, each->ai_socktype, each->ai_protocol);
        if (socket_number >= 0 && connect(socket_number, each->ai_addr, each->ai_addrlen) != 0) {
            close(socket_number);
            socket_number = -1;
        }
    }
    freeaddrinfo(found);
    if (socket_number < 0) fail("%s:%s: %s", login->host, login->port, strerror(errno));
    int on = 1;
    setsockopt(socket_number, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on);
    return (Link){.socket = socket_number, .bytes = resized(NULL, READ_ROOM), .capacity = READ_ROOM};
}

/* Sends bytes. That the server has gone is told by `hear`. */
static void say(Link *link, const char *bytes, size_t length) {
    while (length > 0) {
        ssize_t sent = send(link->socket, bytes, length, MSG_NOSIGNAL);
        if (sent < 0 && errno == EINTR) continue;
        if (sent <= 0) return;
        bytes += sent;
        length -= (size_t)sent;
    }
}

/* Reads the next message into `message`; returns NULL where the connection is cut. */
static const Value *hear(Link *link, Message *message) {
    char *newline;
    while (!(newline = memchr(link->bytes + link->scanned, '\n', link->length - link->scanned))) {
        link->scanned = link->length;
        if (link->capacity == link->length) link->bytes = resized(link->bytes, link->capacity *= 2);
        ssize_t got = recv(link->socket, link->bytes + link->length, link->capacity - link->length, 0);
        if (got < 0 && errno == EINTR) continue;
        if (got <= 0) return NULL;
        link->length += (size_t)got;
    }
    size_t line_length = (size_t)(newline - link->bytes) + 1;
    forget(message);
    message->line = resized(NULL, line_length);
    memcpy(message->line, link->bytes, line_length);
    message->line[line_length - 1] = 0;
    memmove(link->bytes, link->bytes + line_length, link->length -= line_length);
    link->scanned = 0;
    message->at = message->line;
    return read_value(message);
}

/* Says what is to be said about the present view, in one write. */
static void answer(Link *link, View *view, const Bot *bot, int conformance) {
    char text[96];
    view->out_length = view->out_message = view->next_seq = 0;
    if (bot->on_cycle) bot->on_cycle(view, bot->mine);
    end_commands(view);
    if (conformance) {
        uint32_t low = (uint32_t)check_of(view);
        put(view, text, (size_t)snprintf(text, sizeof text, "{\"ping\":{\"id\":%u}}\n", low));
    }
    if (view->is_lockstep) {
        put(view, text, (size_t)snprintf(text, sizeof text, "{\"done\":{\"cycle\":%u}}\n", view->cycle));
    }
    say(link, view->out, view->out_length);
}

static void conclude(Outcome *outcome, const View *view, const Value *result) {
    size_t length = 0;
    outcome->seat = view->seat;
    outcome->cycles = whole_field(result, "cycles");
    snprintf(outcome->hash, sizeof outcome->hash, "%s", field(result, "hash")->text);
    outcome->winners[0] = 0;
    for EACH(seat, field(result, "winners")) {
        if (length + 16 > sizeof outcome->winners) break;
        length += (size_t)sprintf(outcome->winners + length, length ? ",%u" : "%u", whole(seat));
    }
}

/* Plays until the match has ended, and returns 1, or until the connection is cut, and returns 0. */
static int play_on(Link *link, View *view, const Bot *bot, const Login *login, Outcome *outcome) {
    Message message = {0};
    const Value *heard;
    while ((heard = hear(link, &message))) {
        const Value *fields = heard->first;
        if (!fields) fail("the server sent an empty message");
        if (strcmp(fields->key, "welcome") == 0) {
            view->message = message;
            message = (Message){0};
            begin(view, fields);
            if (bot->on_start) bot->on_start(view, bot->mine);
        } else if (strcmp(fields->key, "delta") == 0) {
            apply(view, fields);
            outcome->checks++;
            answer(link, view, bot, login->conformance);
        } else if (strcmp(fields->key, "keyframe") == 0) {
            begin_again(view);
        } else if (strcmp(fields->key, "warned") == 0) {
            const Value *reason = field(fields, "reason");
            fprintf(stderr, "the server warns: %s\n", reason->kind == TEXT ? reason->text : reason->first->key);
        } else if (strcmp(fields->key, "refused") == 0) {
            const Value *reason = field(fields, "reason");
            const Value *problem = reason->first ? find(reason->first, "problem") : NULL;
            fail("the server refused: %s %s", reason->kind == TEXT ? reason->text : reason->first->key,
                 problem ? problem->text : "");
        } else if (strcmp(fields->key, "ended") == 0) {
            const Value *result = field(fields, "result");
            if (bot->on_end) bot->on_end(result, bot->mine);
            conclude(outcome, view, result);
            forget(&message);
            return 1;
        }  /* `pong` and `paused` need no answer. */
    }
    forget(&message);
    return 0;
}

/* Plays a match to its end. */
static Outcome play(const Bot *bot, const Login *login) {
    Outcome outcome = {0};
    for (int connection = 0; connection <= RECONNECTS_MAX; connection++) {
        char hello[512];
        View view = {0};
        Link link = link_to(login);
        int length = snprintf(hello, sizeof hello,
                              "{\"hello\":{\"protocol\":%d,\"client\":\"maniple.c 1.0\",\"player\":\"%s\",\"token\":\"%s\"}}\n",
                              PROTOCOL, bot->name, login->token);
        if (length < 0 || (size_t)length >= sizeof hello) fail("name or token are too long");
        if (login->match) {
            char enter[128];
            int size = snprintf(enter, sizeof enter, "{\"enter\":{\"match\":\"%s\",\"seat\":null}}\n", login->match);
            if (size < 0 || (size_t)size >= sizeof enter) fail("the number of a match has 16 digits");
            say(&link, enter, (size_t)size);
        }
        say(&link, hello, (size_t)length);
        int has_ended = play_on(&link, &view, bot, login, &outcome);
        int was_welcome = view.rules != NULL;
        end(&view);
        free(link.bytes);
        close(link.socket);
        if (has_ended) return outcome;
        if (!was_welcome || !login->token[0]) break;
        nanosleep(&(struct timespec){.tv_nsec = 200000000}, NULL);  /* the server lets nobody in more often */
    }
    fail("the server closed the connection without a word");
    return outcome;
}

#ifndef MANIPLE_NO_MAIN

/* --- the bot of the program: sends its units straight to their zone, or, where the match has none, to fight on the other
 * side of the map. Who was stopped steps aside. Buildings train what they can pay for. */

typedef struct {
    uint32_t seed;
    int has_zone;
    double low[2], high[2];  /* corners of the zone */
    unsigned char *tries;    /* by handle */
    uint32_t tries_count;
} Straight;

/* Returns a number that looks random, and is the same in each run (Park and Miller, 1988). */
static double between(Straight *straight, double low, double high) {
    straight->seed = (uint32_t)((uint64_t)straight->seed * 48271 % 0x7fffffff);
    return low + (high - low) * (straight->seed / (double)0x7fffffff);
}

static void straight_on_start(View *view, void *mine) {
    Straight *straight = mine;
    const Value *race = find(field(view->rules, "objective"), "race");
    straight->seed = view->seat + 1;
    if (!race) return;
    for EACH(zone, field(race, "zones")) {
        if (whole_field(zone, "seat") != view->seat) continue;
        straight->has_zone = 1;
        for (uint32_t axis = 0; axis < 2; axis++) {
            straight->low[axis] = item(field(zone, "min"), axis)->number;
            straight->high[axis] = item(field(zone, "max"), axis)->number;
        }
    }
}

static unsigned char *tries_of(Straight *straight, uint32_t handle) {
    if (handle >= straight->tries_count) {
        straight->tries = resized(straight->tries, (size_t)handle * 2 + 64);
        memset(straight->tries + straight->tries_count, 0, (size_t)handle * 2 + 64 - straight->tries_count);
        straight->tries_count = handle * 2 + 64;
    }
    return &straight->tries[handle];
}

static void send_unit(Straight *straight, View *view, const Object *unit, int has_weapon) {
    const double here[2] = {x_of(view, unit), y_of(view, unit)}, size[2] = {view->width, view->height};
    unsigned char *tries = tries_of(straight, unit->handle);
    double goal[2], aside[2];
    if (*tries < UINT8_MAX) ++*tries;
    for (int axis = 0; axis < 2; axis++) {
        double reach = fmin(*tries, 8.0);
        goal[axis] = straight->has_zone ? between(straight, straight->low[axis], straight->high[axis])
                                        : size[axis] - here[axis];
        aside[axis] = fmin(fmax(here[axis] + between(straight, -reach, reach), 0.0), size[axis]);
    }
    if (*tries > 1 && between(straight, 0.0, 1.0) < 0.5) order_path(view, unit->handle, aside, goal);
    else if (!straight->has_zone && has_weapon) order_attack_move(view, unit->handle, goal[0], goal[1]);
    else order_move(view, unit->handle, goal[0], goal[1]);
}

static void straight_on_cycle(View *view, void *mine) {
    Straight *straight = mine;
    for (size_t i = 0; i < view->count; i++) {
        const Object *thing = &view->objects[i];
        if (!thing->is_own) continue;
        const Value *type = type_of(view, thing);
        double x = x_of(view, thing), y = y_of(view, thing);
        int is_there = straight->has_zone && straight->low[0] <= x && x <= straight->high[0] && straight->low[1] <= y &&
                       y <= straight->high[1];
        if (field(type, "speed")->number > 0.0) {
            if (is_moving(thing) || is_there || thing->own.task == TASK_ATTACK_MOVE) continue;
            send_unit(straight, view, thing, field(type, "weapon")->kind != NOTHING);
        } else if (thing->own.training == UINT32_MAX) {
            for EACH(each, field(type, "trains")) {
                const Value *making = field(item(field(view->rules, "unit_types"), whole(each)), "making");
                if (whole_field(making, "cost") > view->stock) continue;
                order_train(view, thing->handle, whole(each));
                break;
            }
        }
    }
}

int main(int count, char **words) {
    const char *plain[3] = {NULL, NULL, ""}, *match = NULL;
    int plain_count = 0, conformance = 0, is_wrong = 0;
    for (int i = 1; i < count; i++) {
        if (strcmp(words[i], "--conformance") == 0) conformance = 1;
        else if (strncmp(words[i], "--match=", 8) == 0) match = words[i] + 8;
        else if (strncmp(words[i], "--", 2) != 0 && plain_count < 3) plain[plain_count++] = words[i];
        else is_wrong = 1;
    }
    if (is_wrong || plain_count < 2) fail("usage: maniple-c HOST PORT [TOKEN] [--match=NUMBER] [--conformance]");
    Straight straight = {0};
    Bot bot = {"straight.c", straight_on_start, straight_on_cycle, NULL, &straight};
    Login login = {plain[0], plain[1], plain[2], conformance, match};
    Outcome outcome = play(&bot, &login);
    printf("{\"seat\":%u,\"winners\":[%s],\"cycles\":%u,\"hash\":\"%s\",\"checks\":%u}\n", outcome.seat, outcome.winners,
           outcome.cycles, outcome.hash, outcome.checks);
    free(straight.tries);
    return 0;
}

#endif
