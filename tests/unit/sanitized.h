/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_TEST_SANITIZED_H
#define FEWRAY_TEST_SANITIZED_H

/* Whether a sanitizer that owns the allocator is built in, by gcc's and Clang's ways to tell. */

#ifdef __has_feature
#define SANITIZED_BY_CLANG (__has_feature(address_sanitizer) || __has_feature(thread_sanitizer))
#else
#define SANITIZED_BY_CLANG 0
#endif

#if SANITIZED_BY_CLANG || defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED 1
#else
#define SANITIZED 0
#endif

#endif
