/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_TEAM_H
#define FEWRAY_GUIDE_SCENE_TEAM_H

/* Work within one file or mesh is cut into tasks, which those threads of the surrounding parallel
 * region take that have no file or mesh of their own. Without one the caller does them all:
 *
 *     #pragma omp taskloop num_tasks(team_tasks()) if (team_pays(count))
 */

#include <omp.h>
#include <stdbool.h>
#include <stddef.h>

/* Enough to even out the load. libgomp gives a loop of more than 64 tasks a thread to one thread.
 */
static inline int team_tasks(void) {
    return 8 * omp_get_num_threads();
}

/* Whether so many vertices or triangles are worth the tasks. */
static inline bool team_pays(size_t count) {
    return count > 1 << 14;
}

#endif
