"""The seeded bugs of mutants.py: the mistakes that renderers have had, as edits of this one.

A bug is its name, its edits (file, exact text, text in its place), and the tests that are tried first, the cheapest
that may find it in front. A text must be in its file once. Who changes a line that stands here changes it here, too;
who adds a feature adds the bugs that it invites.
SPDX-License-Identifier: MIT
"""

TRACE = "common/trace/"


def bug(name, edits, *tests):
    """edits: (file, text, text in its place), ..., the file without common/trace/ unless it has a folder."""
    return name, [((file if "/" in file or file == "Makefile" else TRACE + file), old, new)
                  for file, old, new in edits], tests


MUTANTS = [
    # --- scattering ---
    bug("cosine omitted",
        [("bsdf.c", "return m->diffuse.albedo * diffuse_pdf_w(wo, wi);",
          "return m->diffuse.albedo * (wo[2] * wi[2] > 0 ? FMATH_INV_PI : 0);"),
         ("path8.c", "vec8_scale(v->albedo, to->pdf_w)", "vec8_scale(v->albedo, f32x8_splat(FMATH_INV_PI))")],
        "bsdf", "truth"),
    bug("cosine doubled",
        [("bsdf.c", "return m->diffuse.albedo * diffuse_pdf_w(wo, wi);",
          "return m->diffuse.albedo * diffuse_pdf_w(wo, wi) * __builtin_fabsf(wi[2]);"),
         ("path8.c", "vec8_scale(v->albedo, to->pdf_w)", "vec8_scale(v->albedo, to->pdf_w * from_wo(v->wo.z, wi))")],
        "bsdf", "truth"),
    bug("1 / pi dropped",
        [("bsdf.c", "return m->diffuse.albedo * diffuse_pdf_w(wo, wi);",
          "return m->diffuse.albedo * diffuse_pdf_w(wo, wi) * FMATH_PI;"),
         ("path8.c", "vec8_scale(v->albedo, to->pdf_w)", "vec8_scale(v->albedo, from_wo(v->wo.z, wi))")],
        "bsdf", "truth"),
    bug("BSDF pdf x 1.01, diffuse",
        [("bsdf.c", "return diffuse_pdf_w(wo, wi);", "return 1.01f * diffuse_pdf_w(wo, wi);"),
         ("bsdf.c", "s->pdf_w = warp_cosine_pdf_w(wi[2]);", "s->pdf_w = 1.01f * warp_cosine_pdf_w(wi[2]);"),
         ("path8.c", "n->pdf_w = warp8_cosine_pdf_w(n->wi.z);", "n->pdf_w = 1.01f * warp8_cosine_pdf_w(n->wi.z);"),
         ("path8.c", "to->f = vec8_scale(v->albedo, to->pdf_w);",
          "to->f = vec8_scale(v->albedo, to->pdf_w);\n    to->pdf_w *= 1.01f;")],
        "bsdf", "materials"),
    bug("BSDF pdf x 1.01, GGX",
        [("microfacet.h", "return microfacet_d(m, alpha) * 0.5f / (o[2]",
          "return microfacet_d(m, alpha) * 0.505f / (o[2]")], "bsdf", "materials"),
    bug("G with alpha instead of alpha^2",
        [("microfacet.h", "const float aa = alpha * alpha;\n    return __builtin_sqrtf(",
          "const float aa = alpha;\n    return __builtin_sqrtf(")], "bsdf", "materials"),
    bug("visible facets' pdf without G1",
        [("microfacet.h", "return microfacet_d(m, alpha) * 0.5f / (o[2] + microfacet_s(o, alpha));",
          "return microfacet_d(m, alpha) * 0.25f / o[2];")], "bsdf", "materials"),
    bug("visible facets' pdf without G1, two widths",
        [("facet.h", "return facet_d(m, a) * 0.5f / (o[2] + facet_s(o, a));",
          "return facet_d(m, a) * 0.25f / o[2];")], "metal"),
    bug("eta^2 missing, smooth glass",
        [("bsdf.c", "s->weight = rgb_gray(s->scale);", "s->weight = rgb_gray(1);")], "materials", "truth"),
    bug("eta^2 missing, rough glass",
        [("bsdf_glass.c", "return microfacet_g1(upright(wi), m->dielectric.alpha) * scale;",
          "(void)scale;\n    return microfacet_g1(upright(wi), m->dielectric.alpha);")], "materials", "path"),
    bug("total reflection as absorption, smooth glass",
        [("bsdf.c", "    if (lobe < f) {\n", "    if (f == 1)\n        return false;\n    if (lobe < f) {\n")],
        "bsdf", "truth"),
    bug("total reflection as absorption, rough glass",
        [("bsdf_glass.c", "if (!(reflects ? i[2] > 0 : i[2] < 0))",
          "if (!(reflects ? i[2] > 0 && fresnel_dielectric(cos, eta, &cos_t) < 1 : i[2] < 0))")],
        "materials", "path"),
    bug("eta^2 missing, several facets of glass",
        [("bsdf_glass.c", "const float nn = wo[2] > 0 ? 1 : s.of.ior * s.of.ior;", "const float nn = 1;")], "glass"),
    bug("what layers hold back given back twice",
        [("stack.c", "return sum * (1.0f / 65535);", "return sum * (2.0f / 65535);")], "coats"),
    bug("what layers keep from inside is lost",
        [("bsdf_inside.c", "f += v->clear * kept_eval(v, upright(wo), upright(wi));", "f += rgb_gray(0);")], "inside"),
    bug("Fresnel's n inverted inside",
        [("bsdf.c", "const float f = fresnel_dielectric(wo[2] > 0 ? wo[2] : -wo[2], eta, &cos_t);",
          "fresnel_dielectric(wo[2] > 0 ? wo[2] : -wo[2], eta, &cos_t);\n    float unused;\n"
          "    const float f = fresnel_dielectric(wo[2] > 0 ? wo[2] : -wo[2], m->dielectric.ior, &unused);")],
        "materials", "truth"),

    # --- lights ---
    bug("light's pick pdf x 1.005",
        [("light.c", "return (double)cdf[emitter + 1] - (double)cdf[emitter];",
          "return 1.005 * ((double)cdf[emitter + 1] - (double)cdf[emitter]);"),
         ("light8.c", "c->probability = f32x8_join(p0, p1);", "c->probability = 1.005f * f32x8_join(p0, p1);")],
        "light", "truth"),
    bug("a light's back shines, met by chance",
        [("path.c", "if (v->at.emitter == STAGE_NONE || !(v->wo[2] > 0))", "if (v->at.emitter == STAGE_NONE)"),
         ("path8.c", "(i32x8)(v->emitter != STAGE_NONE) & (v->wo.z > 0)", "(i32x8)(v->emitter != STAGE_NONE)")], "truth"),
    bug("a light's back shines, chosen",
        [("light.c", "return cos > 0 ? dd / (cos * area) : 0;", "return dd / (__builtin_fabsf(cos) * area);"),
         ("light8.c", "const f32x8 cos = -vec8_dot(d, on.ng) / length;",
          "const f32x8 cos = f32x8_abs(vec8_dot(d, on.ng) / length);")], "truth"),
    bug("occluders throw no shadow",
        [("wave.c", "seen = ~bvh_hit_any_8(w->stage, d->lanes | d->others, w->shadows);",
          "seen = ~(0 & bvh_hit_any_8(w->stage, d->lanes | d->others, w->shadows));")], "truth", "path"),

    bug("a sun met by chance counts in full",
        [("path.c", "light += found * (pdf_w == 0 ? 1 : mis_weight(pdf_w, sampled * path_trust(s)->light));",
          "light += found;")], "truth_lights"),

    # --- paths ---
    bug("MIS weights add up to .99",
        [("path.c", "return 1 / (1 + r * r);", "return 0.99f / (1 + r * r);"),
         ("path8.c", "return 1 / (1 + r * r);", "return 0.99f / (1 + r * r);")], "truth"),
    bug("roulette without 1 / q",
        [("path.c", "p->throughput /= q;", "(void)q;"),
         ("path8.c", "p->throughput = vec8_over(p->throughput, q);", "(void)q;")], "roulette"),
    bug("roulette's 1 / q twice",
        [("path.c", "p->throughput /= q;", "p->throughput /= q * q;"),
         ("path8.c", "p->throughput = vec8_over(p->throughput, q);",
          "p->throughput = vec8_over(p->throughput, q * q);")], "roulette"),
    bug("depth off by one",
        [("wave.c", "w->bounce + 1 < w->max_bounces",
          "w->bounce < w->max_bounces")], "truth"),

    # --- geometry ---
    bug("offset on the wrong side",
        [("surface.h", "vec3_dot(dir, s->ng) < 0 ? -distance", "vec3_dot(dir, s->ng) > 0 ? -distance"),
         ("surface8.h", "f32x8_choose(behind, -distance, distance)", "f32x8_choose(behind, distance, -distance)")],
        "surface"),
    bug("edges: < instead of <=",
        [("bvh_leaf.h", "i32x8_mask((least >= none) | (most <= none))",
          "i32x8_mask((least > none) | (most < none))"),
         ("tri.h", "return (e.e0 >= 0 && e.e1 >= 0 && e.e2 >= 0) || (e.e0 <= 0 && e.e1 <= 0 && e.e2 <= 0);",
          "return (e.e0 > 0 && e.e1 > 0 && e.e2 > 0) || (e.e0 < 0 && e.e1 < 0 && e.e2 < 0);")], "watertight"),
    bug("a child of the tree skipped for a direction of -0",
        [("box8.h", "r->planes = box8_planes[i32x4_mask(back) & 7];",
          "r->planes = box8_planes[i32x4_mask((i32x4)dir < 0) & 7];"),
         ("box8.h", "r->negative[k] = i32x8_mask(back);", "r->negative[k] = i32x8_mask((i32x8)dir[k] < 0);")],
        "watertight"),

    # --- samples and sums ---
    bug("a seed used for two replicates",
        [("rng.h", "pixel_key ^ (frame << 8 | replicate)", "pixel_key ^ (frame << 8 | replicate >> 1)")], "sobol"),
    bug("two dimensions equal",
        [("rng.h", "RNG_PURPOSES = RNG_ROULETTE + 1", "RNG_PURPOSES = RNG_ROULETTE")], "sobol"),
    bug("float accumulator, the film",
        [("common/film.c", "f->sum[3 * at + c] += total[c];",
          "f->sum[3 * at + c] = (double)((float)f->sum[3 * at + c] + (float)total[c]);")], "film", "path"),
    bug("float accumulator, a pass",
        [("render.c", "to->sums[i] += f64x4_of(radiance[i]);",
          "to->sums[i] = f64x4_of(f64x4_round(to->sums[i]) + radiance[i]);")], "path"),
    bug("a standard error of sd / 8",
        [("common/estimate.c", "sqrt(square / ((FILM_REPLICATES - 1) * FILM_REPLICATES))",
          "sqrt(square / (FILM_REPLICATES - 1)) / FILM_REPLICATES")], "coverage", "film"),
    bug("error bars that do not hold are trusted",
        [("common/evidence_bars.c", "!(all[i].hold && missed_around(f->window, all, i) <= most_around * all[i].bar)",
          "!(all[i].hold + missed_around(f->window, all, i) >= most_around * 0)")], "coverage"),
    bug("the error's interval knows chance alone",
        [("common/estimate.c", "e.crossed + 2 * sqrt(e.crossed2)", "0")], "coverage"),
    bug("a tile's border counted twice",
        [("common/tile.c", "min_u32(x + g->tile_px, g->window.x_end)",
          "min_u32(x + g->tile_px + 1, g->window.x_end)")], "tile"),

    # --- the build: last, since it makes everything anew ---
    bug("products contracted into fused multiply-adds",
        [("Makefile", "FLOAT := -ffp-contract=off", "FLOAT := -ffp-contract=fast")], "canary"),
]
