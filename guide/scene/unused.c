/* SPDX-License-Identifier: Apache-2.0 */
/* What a scene's file holds and no shape needs. */

#include <string.h>

#include "guide/scene/loader.h"

int unused_textures(const struct xml_document *document) {
    int count = 0;
    const struct xml_node *node = document->root;
    while (node) {
        const char *type = xml_attribute(node, "type");
        count +=
            !strcmp(node->tag, "texture") && type && !strcmp(type, "bitmap") && node->index < 0;
        if (node->first_child) {
            node = node->first_child;
            continue;
        }
        while (node && node != document->root && !node->next)
            node = node->parent;
        node = node == document->root ? NULL : node->next;
    }
    return count;
}
