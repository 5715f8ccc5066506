/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to the options of commands: what checks and stores their values. */
#ifndef SC_CLI_OPTION_VALUES_H
#define SC_CLI_OPTION_VALUES_H

#include "segcast/cli.h"

/* For sc_option.store. All of them log what is wrong with a value, and return SC_ERR_USAGE. */

/* For an option that sets a key of the job: as a setting, which messages call by the option's name.
 */
sc_status sc_store_key(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                       const char *value);
/* Of --set KEY.PATH=VALUE: as a setting. An equals sign within quotes belongs to the path. */
sc_status sc_store_set(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                       const char *value);
/* A number of threads. */
sc_status sc_store_threads(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                           const char *value);
/* A number of things, from 1 on, in the int at option->offset. */
sc_status sc_store_count(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                         const char *value);
/* A limit of memory. */
sc_status sc_store_max_memory(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                              const char *value);
/* The number of a frame, from 0 on. */
sc_status sc_store_frame(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                         const char *value);
/* Of --sheet: a number of pictures, views or slices. */
sc_status sc_store_sheet(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                         const char *value);
/* Of --view: where an orbit begins and how high, as settings. */
sc_status sc_store_view(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                        const char *value);
/* Of --tissue of pictures: the verb that frames it from the beginning on, as settings. */
sc_status sc_store_framed(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                          const char *value);
/* The address of the value, which is part of argv, in the member at option->offset. */
sc_status sc_store_text(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                        const char *value);
/* As sc_store_text, for the path of an output, which is neither empty nor begins with "~". */
sc_status sc_store_output(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                          const char *value);
/* As sc_store_text, of a list of frames. */
sc_status sc_store_frames(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                          const char *value);
/* True, in the bool at option->offset. */
sc_status sc_store_flag(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                        const char *value);
/* I/N: part I of N, counted from 0. */
sc_status sc_store_slice(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                         const char *value);
/* A time limit. 0 becomes a millisecond, because 0 stands for none. */
sc_status sc_store_time_limit(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                              const char *value);
/* A moment of the film: a time, or a share of the film such as 50%. */
sc_status sc_store_moment(const sc_ctx *ctx, sc_options *options, const sc_option *option,
                          const char *value);

/* For values of the environment as well. @return SC_ERR_USAGE, logged. */

/* Set the number of threads. @param name what messages call its source. */
sc_status sc_options_set_threads(const sc_ctx *ctx, sc_options *options, const char *name,
                                 const char *value);
/* Set the limit of memory: a number of bytes, or of K, M, G or T (powers of 1,024), such as 1.5G or
 * 64GiB. @param name what messages call its source. */
sc_status sc_options_set_max_memory(const sc_ctx *ctx, sc_options *options, const char *name,
                                    const char *value);

/* Refuse a path that begins with "~", which only a shell replaces. @param what it is, for the
 * message. @return SC_ERR_USAGE, logged. */
sc_status sc_check_tilde(const sc_ctx *ctx, const char *what, const char *path);

#endif
