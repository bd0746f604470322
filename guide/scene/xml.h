/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_XML_H
#define FEWRAY_GUIDE_SCENE_XML_H

/* A scene file as a tree of elements, with Mitsuba's <default>s already put in place of $name. */

#include <stdbool.h>

#include "features/features.h"

struct xml_attribute {
    char *name, *value;
};

struct xml_node {
    char *tag;
    struct xml_attribute *attributes;
    int attribute_count;
    int line;
    struct xml_node *first_child, *next; /* children in the file's order */
    struct xml_node *last_child, *parent;

    /* For whoever reads the tree. */
    bool used; /* somebody asked for this parameter */
    bool busy; /* being read: a reference back to it is a cycle */
    int index; /* of what was made of it; -1 = nothing yet */
};

struct xml_id {
    const char *id;
    struct xml_node *node;
};

struct xml_document {
    struct xml_node *root;
    struct xml_id *ids; /* sorted by id */
    int id_count, id_capacity;
    void *blocks; /* memory of all nodes and strings */
};

/* Reads a file. defines ("name=value") take precedence over the file's <default>s; one that the
 * file never uses is an error, so that a mistyped name is noticed. Refuses entity declarations
 * (they can grow without bound) and absurd depth. *out is owned by the caller. */
int xml_read(const char *path, const char *const *defines, int define_count,
             struct xml_document **out, struct fewray_error *error);
void xml_destroy(struct xml_document **document);

/* The attribute's value, or NULL. */
const char *xml_attribute(const struct xml_node *node, const char *name);

/* The element with this id, or NULL. */
struct xml_node *xml_find_id(const struct xml_document *document, const char *id);

#endif
