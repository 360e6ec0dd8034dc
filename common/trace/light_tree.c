/* SPDX-License-Identifier: MIT */
#include "common/trace/light_tree.h"

#include "common/trace/fetch.h"
#include "common/trace/simd.h"

/* Cosines below it count as much, so that what is just in sight is not lost in rounding; and angles
 * whose cosines are nearer than that are not told apart. */
#define LEAST_COSINE 0x1p-10f

struct angle { /* lane by lane */
    f32x8 cosine, sine;
};

static struct angle angle_of(f32x8 cosine)
{
    const f32x8 zero = {0};
    return (struct angle){cosine, f32x8_sqrt(f32x8_max(1 - cosine * cosine, zero))};
}

/* a - b, but not below 0; both in [0, pi]. */
static struct angle angle_less(struct angle a, struct angle b)
{
    const f32x8 zero = {0}, one = zero + 1;
    const i32x8 below = a.cosine >= b.cosine;
    return (struct angle){
        f32x8_choose(below, one, a.cosine * b.cosine + a.sine * b.sine),
        f32x8_choose(below, zero, a.sine * b.cosine - a.cosine * b.sine),
    };
}

struct view {          /* of the lanes, from a point */
    f32x8 d[3], dd;    /* to their centres */
    f32x8 inverse;     /* of the distance */
    i32x8 inside;      /* their spheres hold the point */
    struct angle half; /* that they fill; else anything */
};

static void look(const struct stage_light_node *n, vec3 p, struct view *v)
{
    const f32x8 r = f32x8_load(n->radius);
    for (int k = 0; k < 3; k++)
        v->d[k] = f32x8_load(n->center[k]) - p[k];
    v->dd = v->d[0] * v->d[0] + v->d[1] * v->d[1] + v->d[2] * v->d[2];
    v->inverse = 1 / f32x8_sqrt(v->dd);
    v->inside = v->dd <= r * r;
    const f32x8 zero = {0}, sine = r * v->inverse;
    v->half = (struct angle){f32x8_sqrt(f32x8_max(1 - sine * sine, zero)), sine};
}

/* The largest cosine under which one of them shines to the point; 0: none does. */
static f32x8 sent(const struct stage_light_node *n, const struct view *v)
{
    const f32x8 zero = {0}, one = zero + 1;
    const f32x8 along = f32x8_load(n->axis[0]) * v->d[0] + f32x8_load(n->axis[1]) * v->d[1] +
                        f32x8_load(n->axis[2]) * v->d[2];
    const struct angle facing = angle_of(f32x8_load(n->facing));
    const struct angle a = angle_less(angle_of(-along * v->inverse), facing);
    const f32x8 cosine = angle_less(a, v->half).cosine;
    const i32x8 beyond = cosine < f32x8_load(n->reach) - LEAST_COSINE;
    const f32x8 most = f32x8_max(cosine, zero + LEAST_COSINE);
    return f32x8_choose(v->inside, one, f32x8_choose(beyond, zero, most));
}

/* Between the largest cosine under which one of them arrives and that of their middle, of which the
 * lights of a group that is large or near mostly have less than the largest: no more than four
 * times too small, and with a quarter of the variance. 0: all are behind the surface. */
static f32x8 received(const struct stage_light_node *n, const struct view *v,
                      const struct surface *from)
{
    const f32x8 zero = {0}, one = zero + 1;
    const vec3 up = from->lit < 0 ? -from->ng : from->ng;
    f32x8 height = v->d[0] * up[0] + v->d[1] * up[1] + v->d[2] * up[2];
    if (from->lit == 0)
        height = f32x8_abs(height);
    const f32x8 middle = height * v->inverse;
    const f32x8 cosine = angle_less(angle_of(middle), v->half).cosine;
    const f32x8 most = f32x8_choose(v->inside, one, f32x8_max(cosine, zero + LEAST_COSINE));
    const f32x8 doubt = f32x8_sqrt(v->dd) * 0x1p-20f;
    const i32x8 below = height + f32x8_load(n->radius) < -doubt;
    return f32x8_choose(below, zero, 0.25f * most + 0.75f * f32x8_max(middle, zero));
}

struct weights {
    _Alignas(32) float of[STAGE_LANES];
    f64x4 upto[2]; /* the sums of all lanes up to each, itself included; the last is that of all */
};

static double sum_of(const struct weights *w)
{
    return w->upto[1][3];
}

static f64x4 sums_upto(f64x4 x)
{
    const f64x4 zero = {0};
    x += __builtin_shufflevector(zero, x, 0, 4, 5, 6);
    return x + __builtin_shufflevector(zero, x, 0, 1, 4, 5);
}

/* inner: of a node that was not passed by, of whose children none need be in sight. */
static void weigh(const struct stage_light_node *n, const struct surface *from, bool inner,
                  struct weights *w)
{
    const f32x8 zero = {0}, r = f32x8_load(n->radius);
    struct view v;
    look(n, from->p, &v);
    f32x8 cosines = received(n, &v, from);
    if (!(n->child[0] & STAGE_LIGHT_ROUND))
        cosines *= sent(n, &v);
    const f32x8 intensity = f32x8_load(n->intensity);
    /* Nearer than the radius nobody knows how near; and nothing is at a distance of 0 */
    const f32x8 dd = f32x8_max(f32x8_max(v.dd, r * r), zero + 0x1p-120f);
    /* What may send light keeps a chance, whatever the others send */
    const f32x8 weight =
        f32x8_max(f32x8_min(intensity * cosines / dd, zero + 0x1p100f), zero + 0x1p-100f);
    const f32x8 weights = f32x8_choose((cosines > zero) & (intensity > zero), weight, zero);
    const f32x8 all = inner && !i32x8_mask(weights > zero) ? intensity : weights;
    f32x8_store(w->of, all);
    w->upto[0] = sums_upto(f64x4_of(f32x8_low(all)));
    w->upto[1] = sums_upto(f64x4_of(f32x8_high(all))) + w->upto[0][3];
}

/* The lane in whose part x lies, which becomes x's place in it; x in [0, sum]. Without a branch: it
 * would be guessed wrong half of the time. */
static uint32_t choose(const struct weights *w, double *x)
{
    const uint32_t before = i64x4_mask(w->upto[0] <= *x) | i64x4_mask(w->upto[1] <= *x) << 4;
    uint32_t lane = (uint32_t)__builtin_popcount(before); /* they are the lowest */
    if (lane == STAGE_LANES) /* rounding: the last one that has a part */
        for (lane--; !(w->of[lane] > 0);)
            lane--;
    const double weight = (double)w->of[lane], end = w->upto[lane / 4][lane % 4];
    *x = (*x - (end - weight)) / weight;
    *x = *x > 0 ? *x : 0;
    if (!(*x < 0x1.fffffffffffffp-1))
        *x = 0x1.fffffffffffffp-1;
    return lane;
}

static const struct stage_light_node *node_at(const struct stage *s, uint32_t node)
{
    return (const struct stage_light_node *)stage_at(s, s->light_nodes) + node;
}

/* What is looked at. Its size is a number in either case, so that there is no loop. */
static inline void fetch_node(const struct stage_light_node *n, bool round)
{
    if (round)
        fetch_lines(n, offsetof(struct stage_light_node, axis));
    else
        fetch_lines(n, sizeof *n);
}

struct walk {
    const struct stage_light_node *node;
    double u;
    uint32_t which; /* of the points */
};

/* One level down. False: the walk has ended. */
static bool step(const struct stage *s, struct walk *walk, const struct surface *from,
                 struct light_tree_pick *pick)
{
    struct weights w;
    weigh(walk->node, from, walk->node != node_at(s, 0), &w);
    const double sum = sum_of(&w);
    if (!(sum > 0))
        return false;
    double x = walk->u * sum;
    const uint32_t lane = choose(&w, &x);
    const uint32_t child = walk->node->child[lane] & ~STAGE_LIGHT_ROUND;
    walk->u = x;
    pick->probability *= (double)w.of[lane] / sum;
    if (child >= STAGE_LIGHT_LEAF) {
        pick->emitter = child - STAGE_LIGHT_LEAF;
        pick->rest = x;
        fetch_lines(stage_emitter_at(s, pick->emitter), sizeof(struct emitter));
        return false;
    }
    const bool round = walk->node->child[0] & STAGE_LIGHT_ROUND; /* then the child's are, too */
    walk->node = node_at(s, child);
    fetch_node(walk->node, round); /* to be there when it is this walk's turn again */
    return true;
}

void light_tree_pick(const struct stage *s, const struct surface *const from[], const double u[],
                     uint32_t count, struct light_tree_pick picks[])
{
    struct walk walks[LIGHT_TREE_WALKS];
    uint32_t going = count;
    for (uint32_t i = 0; i < count; i++) {
        walks[i] = (struct walk){node_at(s, 0), u[i], i};
        picks[i] = (struct light_tree_pick){STAGE_NONE, 1, 0};
    }
    while (going) {
        const uint32_t turn = going;
        going = 0;
        for (uint32_t i = 0; i < turn; i++) {
            struct walk *walk = &walks[i];
            if (step(s, walk, from[walk->which], &picks[walk->which]))
                walks[going++] = *walk;
        }
    }
}

double light_tree_probability(const struct stage *s, const struct surface *from, uint32_t emitter)
{
    const uint32_t *parents = stage_at(s, s->light_parents);
    uint32_t slots[LIGHT_TREE_DEPTH], depth = 0;
    double probability = 1;
    struct weights w;
    /* All of the way first, so that its nodes come from memory side by side */
    for (uint32_t slot = stage_emitter_at(s, emitter)->slot; slot != STAGE_NONE;
         slot = parents[slot / STAGE_LANES]) {
        fetch_lines(node_at(s, slot / STAGE_LANES), sizeof(struct stage_light_node));
        slots[depth++] = slot;
    }
    while (depth-- > 0) {
        const uint32_t slot = slots[depth];
        weigh(node_at(s, slot / STAGE_LANES), from, slot >= STAGE_LANES, &w);
        if (!(w.of[slot % STAGE_LANES] > 0))
            return 0;
        probability *= (double)w.of[slot % STAGE_LANES] / sum_of(&w);
    }
    return probability;
}
