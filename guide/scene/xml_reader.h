/* SPDX-License-Identifier: Apache-2.0 */
#ifndef FEWRAY_GUIDE_SCENE_XML_READER_H
#define FEWRAY_GUIDE_SCENE_XML_READER_H

/* What the parts of the XML reader share while a scene and the files that it includes are read. */

#include <expat.h>

#include "guide/scene/defines.h"
#include "guide/scene/xml.h"

/* A file being read. */
struct xml_source {
    const struct xml_source *outer; /* the file that includes it, or NULL */
    XML_Parser parser;
    const char *path; /* lives as long as the document */
    int depth;        /* of its own open elements */
    bool included;    /* its <scene>, if it has one, stands for its children */
    bool bare;        /* that <scene> was met: no node is open for it */
};

struct xml_reader {
    struct xml_source *source; /* the innermost */
    struct xml_document *document;
    struct xml_node *current;
    int depth, include_depth;
    int include_count; /* of all files, each as often as it is included */
    bool in_directive; /* within <include>, <path> or <alias>, which hold nothing */
    struct defines defines;
    struct fewray_error *error;
    int status; /* of the first failure; all parsers are stopped then */
};

/* Sets the error to where the innermost parser stands, and stops it. */
void xml_reader_stop(struct xml_reader *reader, enum fewray_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void xml_reader_stop_without_memory(struct xml_reader *reader);

bool xml_reader_add_id(struct xml_reader *reader, const char *id, struct xml_node *node);

/* Reads a file into reader->current, or as the document's root. The error is set. */
int xml_reader_read(struct xml_reader *reader, const char *path);

/* <include>, <path>, <alias>: elements that change how the rest is read, and aren't part of the
 * tree. */
bool xml_is_directive(const char *tag);
void xml_obey_directive(struct xml_reader *reader, const struct xml_node *node);

#endif
