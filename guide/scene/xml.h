/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_XML_H
#define FEWRAY_GUIDE_SCENE_XML_H

/* A scene file as a tree of elements, with Mitsuba's <default>s already put in place of $name, what
 * it includes in its place, and aliases among the ids. */

#include <stdbool.h>

#include "fewray/guide.h"

struct xml_attribute {
    char *name, *value;
};

struct xml_node {
    char *tag;
    struct xml_attribute *attributes;
    int attribute_count;
    int line;
    const char *file;                    /* it or one that it includes; owned by the document */
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
    const char *file; /* where the id is given; of an alias not the node's */
    int line, order;
};

/* A folder that files are looked for in, before the next and the scene's own. */
struct xml_folder {
    const char *path;
    struct xml_folder *next;
};

struct xml_document {
    const char *path; /* of the scene's file */
    struct xml_node *root;
    struct xml_folder *folders;
    struct xml_id *ids; /* sorted by id */
    int id_count, id_capacity;
    bool uses_frame; /* $frame stands somewhere, and no -D fixes it */
    void *blocks;    /* memory of all nodes and strings */
};

/* Reads a file. options->defines ("name=value") and options->frame take precedence over the file's
 * <default>s; one that the file never uses is an error, so that a mistyped name is noticed. Refuses
 * entity declarations (they can grow without bound) and absurd depth. *out is owned by the caller.
 */
int xml_read(const char *path, const struct fewray_scene_options *options,
             struct xml_document **out, struct fewray_error *error);
void xml_destroy(struct xml_document **document);

/* The attribute's value, or NULL. */
const char *xml_attribute(const struct xml_node *node, const char *name);

/* The path of a file that the scene names: in one of its folders or, where it isn't there, beside
 * the scene. malloc'd; NULL: out of memory. */
char *xml_find_file(const struct xml_document *document, const char *filename);

/* The element with this id, or NULL. */
struct xml_node *xml_find_id(const struct xml_document *document, const char *id);

#endif
