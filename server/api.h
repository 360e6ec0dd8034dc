/* api.h - the route table, and the handlers for people: jobs, assets, the page.
 * SPDX-License-Identifier: MIT */
#ifndef SERVER_API_H
#define SERVER_API_H

#include "server/route.h"

extern const struct route api_routes[];
extern const size_t api_route_count;

route_prepare api_prepare_job; /* parses the scene; pool threads */

route_handler api_job_submit, api_job_list, api_job_get, api_job_change, api_job_cancel;
route_handler api_job_document, api_job_plan, api_job_exr, api_job_png, api_job_curve;
route_handler api_asset_put, api_asset_get;
route_handler api_health, api_static;

#endif
