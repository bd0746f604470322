/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TESTS_FAULT_WRAP_H
#define FEWRAY_TESTS_FAULT_WRAP_H

/* Allocations of our own code, which the linker sends here (--wrap); those of shared libraries and
 * of modules aren't seen. */

/* From now on the n-th allocation fails, and all later ones where `later`; 0: none. Starts counting
 * anew. */
void wrap_fail(long n, int later);
/* Allocations since then. */
long wrap_count(void);
/* Blocks that are allocated and not freed. */
long wrap_live(void);

#endif
