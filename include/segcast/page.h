/* SPDX-License-Identifier: BSD-3-Clause */
/** @file
 *  The page that shows runs and studies: one file of HTML with its style and its scripts, which
 *  needs no network and draws what its data say. Its sources lie beside page.c. */
#ifndef SEGCAST_PAGE_H
#define SEGCAST_PAGE_H

#include "segcast/base.h"

/** The page, NUL-terminated; its data belong where it says \@DATA\@. */
extern const char sc_page_html[];

/** The page of the desk, NUL-terminated. It asks the server for its data. */
extern const char sc_desk_html[];

/** Make a page. @param json its data, of which nothing can become HTML. @return SC_ERR_MEMORY.
 *  Caller owns @p out: sc_text_clear. */
SC_MUST_USE sc_status sc_page_make(const sc_ctx *ctx, const char *json, sc_text *out);

#endif
