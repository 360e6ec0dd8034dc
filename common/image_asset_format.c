/* The names of formats, apart from the readers: a coordinator has the ones without the others.
 * SPDX-License-Identifier: MIT */
#include "common/image_asset.h"

#include <string.h>
#include <strings.h>

const char *const image_asset_formats[IMAGE_ASSET_FORMATS] = {
    [IMAGE_FORMAT_PNG] = "png",
    [IMAGE_FORMAT_JPEG] = "jpeg",
    [IMAGE_FORMAT_EXR] = "exr",
};

bool image_asset_format_of(const char *file, enum image_format *format)
{
    static const struct {
        const char *ending;
        enum image_format format;
    } known[] = {{".png", IMAGE_FORMAT_PNG},
                 {".jpg", IMAGE_FORMAT_JPEG},
                 {".jpeg", IMAGE_FORMAT_JPEG},
                 {".exr", IMAGE_FORMAT_EXR}};
    const size_t n = strlen(file);
    for (size_t i = 0; i < countof(known); i++) {
        const size_t e = strlen(known[i].ending);
        if (n >= e && !strcasecmp(file + n - e, known[i].ending)) {
            *format = known[i].format;
            return true;
        }
    }
    return false;
}
