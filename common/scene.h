/* scene.h - the scene description: what the author wrote, checked and with its
 * defaults filled in. READ THIS FIRST.
 *
 *   Length m. Angle rad; degrees only in JSON, named *_deg. Time ms (int64_t, monotonic).
 *   Right-handed, y up, camera looks along -z. uv origin bottom left; pixel origin top left,
 *   pixel (x, y) covers [x, x+1) x [y, y+1).
 *   Directions are unit length unless named *_raw. wo, wi point away from the surface;
 *   cosines are against the shading normal ns unless said; ng is the geometric normal.
 *   Color: linear, Rec. 709 primaries, D65 white. Anything else is named (srgb8).
 *   Radiance W/(m^2 sr). pdf_w per steradian, pdf_a per m^2. float in the core;
 *   double for sums over a whole image and for statistics.
 *
 * A scene is plain data: arrays and indices, no pointers between its objects. All
 * memory belongs to the arena given to scene_parse. Assets are named, not loaded:
 * mesh_read (mesh.h) and image_asset_read (image_asset.h) fill `struct mesh` and
 * `struct image_asset` in a second step, because the coordinator checks documents
 * and never opens an asset.
 *
 * The document format is specified in docs/scene.md.
 * SPDX-License-Identifier: MIT */
#ifndef COMMON_SCENE_H
#define COMMON_SCENE_H

#include "common/arena.h"
#include "common/color.h"
#include "common/err.h"
#include "common/hash.h"

/* What we agree to render. Documents beyond a limit are refused with ERR_LIMIT. */
enum {
    SCENE_MAX_BYTES = 4 * 1024 * 1024,  /* of JSON: jansson needs about 13 times that */
    SCENE_MAX_DEPTH = 32,               /* of nesting */
    SCENE_MAX_SIDE_PX = 16384,          /* film width, height */
    SCENE_MAX_PIXELS = 64 * 1024 * 1024,
    SCENE_MAX_SHAPES = 100000,
    SCENE_MAX_MATERIALS = 10000,
    SCENE_MAX_LIGHTS = 100000,          /* entries that are no shapes */
    SCENE_MAX_TEXTURES = 4096,
    SCENE_MAX_IMAGES = 4096,            /* image assets */
    SCENE_MAX_IMAGE_SIDE_PX = 16384,    /* of one */
    SCENE_MAX_IMAGE_PIXELS = 64 * 1024 * 1024,
    SCENE_MAX_TRIANGLES = 100000000,    /* of one mesh; prep.h bounds the whole scene */
    SCENE_MAX_NAME = 128,               /* bytes of a name or title */
    SCENE_MAX_BOUNCES = 10000,
    SCENE_MAX_BLADES = 64,              /* of an aperture */
    SCENE_MAX_SPP = 1 << 24,
};

enum filter_kind {
    FILTER_BOX,
    FILTER_TENT,
    FILTER_GAUSSIAN,
    FILTER_BLACKMAN_HARRIS,
    FILTER_MITCHELL
};

struct scene_film {
    uint32_t width_px, height_px; /* >= 1; the whole frame */
    /* The part that is rendered, in pixels of the whole frame, half-open. Default: all. */
    uint32_t crop_x_begin, crop_y_begin, crop_x_end, crop_y_end;
    enum filter_kind filter;
    float filter_radius_px; /* half width: box .5 is one pixel, tent 1 reaches the neighbours */
    float filter_sigma_px;      /* GAUSSIAN */
    float filter_b, filter_c;   /* MITCHELL, [0, 1] */
    uint32_t layers;        /* layers.h; 0: the image alone */
};

enum camera_kind { CAMERA_PERSPECTIVE, CAMERA_THIN_LENS, CAMERA_ORTHOGRAPHIC, CAMERA_PANORAMIC };

struct scene_camera {
    enum camera_kind kind;
    struct xform to_world; /* rigid: columns right, up, back (-view), position */
    union {
        struct {             /* PERSPECTIVE, THIN_LENS: */
            float fov_y_rad; /* full vertical opening angle of the whole frame, (0, pi) */
            /* THIN_LENS alone. What lies at the depth `focus` in front of the camera is sharp. */
            float lens_radius; /* [0, focus] */
            float focus;       /* > 0 */
            uint32_t blades;   /* the aperture's corners, on its circle; 0: it is round */
            float blades_turn; /* of the first corner, in turns from right towards up, [0, 1) */
        };
        struct {                 /* ORTHOGRAPHIC: what the whole frame shows, m. One of the two is */
            float width, height; /* 0: it follows from the other and the film */
        };
    };
};

enum material_kind {
    MATERIAL_DIFFUSE,
    MATERIAL_MIRROR,
    MATERIAL_DIELECTRIC,
    MATERIAL_CONDUCTOR,
    MATERIAL_ROUGH_DIFFUSE,
    MATERIAL_RETROREFLECTOR,
    MATERIAL_LEAF,
    MATERIAL_PLASTIC,
    MATERIAL_PRINCIPLED,
    MATERIAL_CLOTH,
    MATERIAL_MIX,
    MATERIAL_MASK,
    MATERIAL_TWO_SIDED,
    MATERIAL_PANE,
    /* From here on without a name in documents. */
    MATERIAL_METAL, /* a "conductor" that asks for more than MATERIAL_CONDUCTOR has */
};

/* What shading with a material asks of the surface beside its place and its normal. */
enum material_needs {
    MATERIAL_NEEDS_UV = 1,      /* uv: a parameter is textured */
    MATERIAL_NEEDS_TANGENT = 2, /* the x axis of the local frame along growing u */
    MATERIAL_NEEDS_COLOR = 4,   /* the mesh's vertex colours */
};

struct thin_film {
    float thickness_nm; /* [0, 2000]; 0: there is none */
    float ior;          /* above 1, at most 4 */
};

/* What lies behind the surface of a dielectric. */
struct inside {
    rgb absorption;    /* 1/m, [0, 1e9] */
    uint32_t priority; /* where bodies overlap, the highest counts; 0: none given */
};

enum material_channel { /* of a texture, as a number */
    MATERIAL_CHANNEL_LUMINANCE,
    MATERIAL_CHANNEL_R,
    MATERIAL_CHANNEL_G,
    MATERIAL_CHANNEL_B,
    MATERIAL_CHANNEL_A,
};

/* A member of a material that a texture drives. */
struct material_slot {
    uint32_t texture; /* index into scene.textures */
    uint32_t member;  /* its offset in struct material */
    uint32_t is_rgb;  /* 1: an rgb; 0: a float */
    enum material_channel channel; /* of a float */
    float lo, hi;     /* the member's range, in which the value is kept */
    float scale[3];   /* times the texture's value; of a float: scale[0] */
};

#define SCENE_NO_TEXTURE UINT32_MAX

/* Shading normals from textures. */
struct material_relief {
    uint32_t normal_map; /* of scene.textures, an image of linear numbers; or SCENE_NO_TEXTURE */
    float strength;      /* times its x and y */
    uint32_t bump;       /* an image, or SCENE_NO_TEXTURE */
    enum material_channel channel; /* of that */
    float height;                  /* m, of the value 1 */
};

struct material {
    const char *name;
    enum material_kind kind;
    uint32_t needs; /* enum material_needs, or-ed */
    struct inside inside;
    uint32_t slot_begin, slot_end; /* of scene.slots. The members they drive hold what the texture's
                                    * value 1 would make of them */
    uint32_t relief; /* 1 + index into scene.reliefs; 0: none. A part of another one has none */
    union {
        struct {
            rgb albedo; /* [0, 1] */
        } diffuse;
        struct {
            rgb reflectance; /* [0, 1] */
        } mirror;
        struct {
            float ior;   /* inside / outside, [1, 4]; inside is where the normal does not point */
            float alpha; /* GGX width, [0, 1]; 0 is smooth */
            bool multiscatter; /* light that meets several facets is added */
        } dielectric;
        struct {
            rgb eta, k;  /* complex index of refraction per channel, eta > 0, k >= 0 */
            float alpha; /* GGX width, [0, 1]; 0 is a perfect mirror with conductor Fresnel */
        } conductor;
        struct {
            rgb albedo;      /* [0, 1] */
            float roughness; /* [0, 1]; 0 is Lambertian */
        } rough_diffuse;
        struct {
            rgb reflectance; /* [0, 1] */
            float alpha;     /* GGX width, [0, 1]; 0 sends light back exactly */
        } retro;
        struct {
            rgb reflectance, transmittance; /* sum in [0, 1] */
        } leaf;
        struct {
            rgb albedo;  /* of the base, [0, 1] */
            float ior;   /* of the coat, [1.1, 3] */
            float alpha; /* GGX width of its facets, [0, 1]; 0 is smooth */
        } plastic;
        struct {
            rgb albedo, color; /* of the base, of the fibres; [0, 1] */
            float roughness;   /* of the fibres, [0.1, 1] */
        } cloth;
        struct { /* all in [0, 1] but ior */
            rgb base_color, sheen_color;
            float metallic, roughness; /* roughness^2 is the GGX width */
            float ior;                 /* [1.1, 3] */
            float transmission;        /* of what is not metal */
            float clearcoat, clearcoat_roughness;
            float sheen_roughness; /* [0.1, 1] */
        } principled;
        struct {
            uint32_t first, second; /* indices into scene.materials */
            float amount;           /* of the second, [0, 1] */
        } mix;
        struct {
            uint32_t of;   /* the material where there is one */
            float opacity; /* [0, 1]; 0: nothing is there, rays go straight on */
        } mask;
        struct {
            uint32_t front, back; /* both opaque */
        } two_sided;
        struct {
            float ior; /* of glass, over that around it, [1, 4] */
        } pane;
        struct {
            rgb eta, k;              /* as a conductor's */
            float alpha_x, alpha_y;  /* GGX width along the x axis of the local frame and across */
            float turn_cos, turn_sin; /* of the angle by which these are turned about the normal */
            bool multiscatter;       /* light that meets several facets is added */
            struct thin_film film;
        } metal;
    };
};

enum image_format { IMAGE_FORMAT_PNG, IMAGE_FORMAT_JPEG, IMAGE_FORMAT_EXR };
enum image_depth { IMAGE_DEPTH_U8, IMAGE_DEPTH_U16, IMAGE_DEPTH_FLOAT };

/* An image that textures or lights name; who names the same one shares it. */
struct image_asset {
    enum image_format format;
    char asset[HASH_HEX]; /* SHA-256 of the bytes; "" when `file` is used */
    const char *file;     /* NULL when `asset` is used; see struct mesh */
    const char *where;    /* JSON pointer to the first object that names it */
    /* Filled by image_asset_read. Whole numbers as they are in the file: u8 / 255, u16 / 65535,
     * and what colour space that is says who uses them. Float: linear and finite, any sign. */
    enum image_depth depth;
    bool half;                    /* IMAGE_DEPTH_FLOAT: every value is one of 16 bits */
    uint32_t width_px, height_px; /* >= 1 */
    uint32_t channels;            /* 1 gray, 2 gray and alpha, 3 RGB, 4 RGB and alpha */
    const void *pixels;           /* uint8_t, uint16_t or float [height][width][channels], rows
                                   * from the top; alpha is not multiplied in */
};

enum texture_kind { TEXTURE_IMAGE, TEXTURE_CHECKER, TEXTURE_VERTEX_COLOR };
enum texture_space { TEXTURE_SRGB, TEXTURE_LINEAR }; /* of the whole numbers of an image */
enum texture_wrap { TEXTURE_REPEAT, TEXTURE_CLAMP, TEXTURE_MIRROR };
enum texture_filter { TEXTURE_TRILINEAR, TEXTURE_BILINEAR, TEXTURE_NEAREST };

struct texture {
    const char *name;
    enum texture_kind kind;
    float uv_scale[2], uv_offset[2]; /* it is looked at in uv times scale plus offset */
    union {
        struct {
            uint32_t image; /* index into scene.images */
            enum texture_space space;
            enum texture_wrap wrap;
            enum texture_filter filter;
        } image;
        struct {
            rgb colors[2]; /* of squares of side 1: of the one at the origin, of its neighbours */
        } checker;
    };
};

enum mesh_format { MESH_INLINE, MESH_PLY, MESH_OBJ };

struct mesh {
    enum mesh_format format;
    /* MESH_PLY, MESH_OBJ: where the bytes are. A document on disk may name a file
     * (relative to the document); what is sent to a coordinator names an asset. */
    char asset[HASH_HEX]; /* SHA-256 of the bytes; "" when `file` is used */
    const char *file;     /* NULL when `asset` is used */
    /* Filled by scene_parse for MESH_INLINE, else by mesh_read. In object space. */
    const float *vertices;   /* [vertex_count][3] */
    const uint32_t *indices; /* [triangle_count][3], each < vertex_count; counter-clockwise is front */
    uint32_t vertex_count, triangle_count;
    /* NULL: it has none. Vertices that differ only in these have the same bits of position. */
    const float *normals; /* [vertex_count][3], unit; 0, 0, 0: none here, its triangles are flat */
    const float *uvs;     /* [vertex_count][2], uv origin bottom left */
    const float *colors;  /* [vertex_count][3], linear */
};

enum mesh_normals {
    MESH_NORMALS_GIVEN, /* the mesh's own; a mesh without them is flat */
    MESH_NORMALS_FLAT,  /* its triangles' */
    MESH_NORMALS_SMOOTH, /* made of its triangles': prep_smooth.c */
};

enum shape_kind { SHAPE_SPHERE, SHAPE_DISC, SHAPE_CYLINDER, SHAPE_QUAD, SHAPE_MESH };

struct shape {
    enum shape_kind kind;
    uint32_t material;     /* index into scene.materials */
    rgb emission;          /* radiance leaving the front side; 0: not a light. Front: outside of a
                            * sphere or cylinder, else the side the normal points to */
    uint32_t glow;         /* 1 + index into scene.textures: emission is multiplied by it; 0: none */
    struct xform to_world; /* but for quads and meshes a similarity (checked), maybe a mirror */
    union {
        struct {
            float center[3], radius; /* radius > 0 */
        } sphere;
        struct {
            float center[3], normal[3], radius; /* normal: unit */
        } disc;
        struct { /* the side alone, open at both ends */
            float from[3], axis[3]; /* axis: from one end to the other, in m */
            float radius;
        } cylinder;
        struct {
            float vertices[4][3]; /* planar, convex, counter-clockwise seen from the front */
        } quad;
        struct {
            uint32_t mesh; /* index into scene.meshes; shapes that name the same one share it */
            enum mesh_normals normals;
        } mesh;
    };
};

enum light_kind {
    LIGHT_SKY,
    LIGHT_POINT,
    LIGHT_DISTANT,
    LIGHT_SPOT,
    LIGHT_SUN,
    LIGHT_ENVIRONMENT,
};

struct light {
    enum light_kind kind;
    union {
        struct {
            rgb radiance; /* the same from every direction; several skies add up */
        } sky;
        struct {
            float position[3];
            rgb intensity; /* W/sr */
        } point;
        struct {
            float direction[3]; /* unit, the way the light travels */
            rgb irradiance;     /* W/m^2 on a surface that faces it */
        } distant;
        struct {
            float position[3], direction[3]; /* direction: unit, the way the light travels */
            rgb intensity;                   /* W/sr, within inner_rad of the direction */
            float inner_rad, outer_rad;      /* outer >= inner: there, and beyond, it is 0 */
        } spot;
        struct {
            float direction[3]; /* unit, the way the light travels from the middle of the disc */
            float radius_rad;   /* of the disc as it is seen, (0, pi/2] */
            rgb radiance, irradiance; /* one is given, the other 0; irradiance of a surface that
                                       * faces it */
        } sun;
        struct {             /* an image of the whole sphere by longitude and latitude */
            uint32_t image;  /* index into scene.images; OpenEXR */
            rgb scale;       /* radiance of a pixel value of 1 */
            struct xform to_world; /* a rotation; not turned, -z is the image's middle, y its top */
        } environment;
    };
};

enum integrator_kind { INTEGRATOR_PATH, INTEGRATOR_DIRECT, INTEGRATOR_WHITTED };

/* How light that lights and surfaces can both find is looked for. */
enum strategy_kind { STRATEGY_MIS, STRATEGY_LIGHT, STRATEGY_BSDF };

enum sampler_kind { SAMPLER_SOBOL, SAMPLER_INDEPENDENT, SAMPLER_STRATIFIED };

struct scene_target {  /* the first one reached ends the job; at least one is set */
    double error;      /* relative error of the image (estimate.h), 0: not set */
    uint32_t spp;      /* samples per pixel; never 0: defaults to SCENE_MAX_SPP beside another
                        * target, to 64 when no target is given */
    double seconds;    /* of wall time from the first lease, 0: not set */
};

struct scene_settings {
    enum integrator_kind integrator;
    enum strategy_kind strategy;
    enum sampler_kind sampler;
    uint32_t max_bounces; /* scattering events per path; 0 shows emission alone. Default 64 */
    float clamp;          /* no sample's largest component is above it: that is scaled down. 0: off */
    uint64_t seed;        /* default 0; [0, 2^53 - 1]: JSON carries it exactly */
    struct scene_target target;
};

/* What reading has changed, since `settings.rescale` allows it. */
struct scene_warning {
    const char *where;        /* JSON pointer */
    const char *what;         /* with both values */
    float was[3], became[3];  /* a colour */
};

struct scene {
    const char *title; /* "" when absent */
    struct scene_film film;
    struct scene_camera camera;
    struct scene_settings settings;
    struct material *materials;
    struct shape *shapes;
    struct mesh *meshes;
    struct light *lights;
    struct texture *textures;
    struct image_asset *images;
    struct material_slot *slots; /* of all materials */
    struct material_relief *reliefs;
    uint32_t material_count, shape_count, mesh_count, light_count, texture_count, image_count;
    uint32_t slot_count, relief_count;
    struct scene_warning *warnings; /* for people */
    uint32_t warning_count;
};

/* What is wrong with a document: all of it at once, in document order. */
struct scene_error {
    enum err_code code; /* ERR_INPUT or ERR_LIMIT */
    const char *where;  /* JSON pointer (RFC 6901; "": the whole document), or "line 3, column 7"
                         * for a syntax error */
    const char *what;   /* found and allowed: "expected a number in (0, 180), got 200" */
};

struct scene_errors {
    struct scene_error *list; /* in the arena; at most 100, the last then says how many more */
    size_t count;
};

enum scene_source {
    SCENE_FROM_DISK, /* meshes and images may name files */
    SCENE_FROM_NET,  /* they name assets only */
};

/* Text (need not be NUL-terminated) to a checked scene. False: `errors` is not empty
 * and `scene` must not be used. Pure: no file is opened. */
bool scene_parse(struct scene *scene, const char *json, size_t bytes, enum scene_source source,
                 struct arena *arena, struct scene_errors *errors) MUST_CHECK;

/* The hash of each file that a document names, by what names it: shapes[i] is the i-th shape's.
 * Only those of objects with a file are looked at, and a list without any may be NULL. */
struct scene_hashes {
    const char (*textures)[HASH_HEX], (*shapes)[HASH_HEX], (*lights)[HASH_HEX];
};

/* The same document with every `file` replaced by its `asset` and `format`, as a coordinator takes
 * it. Returns JSON text in the arena. */
const char *scene_name_assets(const char *json, size_t bytes, const struct scene_hashes *,
                              struct arena *arena);

#endif
