/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_FEATURES_PAGES_H
#define FEWRAY_FEATURES_PAGES_H

/* Large zeroed buffers, in huge pages where the system has them (Linux): faults of small pages and
 * misses of their addresses cost the denoiser a seventh of its time, and a film whose pages are
 * read before they are written a fault twice. Pages that nobody writes to take no memory. */

#include <stddef.h>

/* NULL without memory. Owned by the caller: pages_destroy() with the same number of bytes. */
void *pages_create(size_t bytes);
/* memory may be NULL. */
void pages_destroy(void *memory, size_t bytes);

#endif
