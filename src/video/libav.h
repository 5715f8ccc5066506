/* SPDX-License-Identifier: BSD-3-Clause */
/* Private to video: the functions of libav that it calls. libav depends on more than a hundred
 * libraries, and loading them takes five times as long as loading everything else that segcast is
 * linked with. So they are loaded with the first video: segcast-libav.so, which lies beside the
 * other programs of segcast and is linked with them, holds nothing but addresses of these
 * functions. libavfilter, which takes nearly as long again, and which only GIF files need, is
 * loaded with the first of these, as segcast-libavfilter.so. */
#ifndef SC_VIDEO_LIBAV_H
#define SC_VIDEO_LIBAV_H

#include "segcast/base.h"

#include <libavcodec/avcodec.h>
#include <libavfilter/avfilter.h>
#include <libavfilter/buffersink.h>
#include <libavfilter/buffersrc.h>
#include <libavformat/avformat.h>
#include <libavutil/cpu.h>
#include <libavutil/imgutils.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
#include <libavutil/spherical.h>
#include <libswscale/swscale.h>

/* What is said of a whole stream belongs to its parameters since FFmpeg 6.1. */
#define SC_HAVE_CODED_SIDE_DATA (LIBAVCODEC_VERSION_INT >= AV_VERSION_INT(60, 31, 102))
#if SC_HAVE_CODED_SIDE_DATA
#define SC_LIBAV_SIDE_DATA(X) X(av_packet_side_data_add)
#else
#define SC_LIBAV_SIDE_DATA(X) X(av_stream_add_side_data)
#endif

/* Expand to X(NAME) for each function. */
#define SC_LIBAV_FUNCTIONS(X)                                                                      \
    X(av_dict_free)                                                                                \
    X(av_dict_get)                                                                                 \
    X(av_dict_set)                                                                                 \
    X(av_find_best_stream)                                                                         \
    X(av_frame_alloc)                                                                              \
    X(av_frame_free)                                                                               \
    X(av_frame_get_buffer)                                                                         \
    X(av_frame_make_writable)                                                                      \
    X(av_frame_unref)                                                                              \
    X(av_free)                                                                                     \
    X(av_freep)                                                                                    \
    X(av_get_cpu_flags)                                                                            \
    X(av_image_copy)                                                                               \
    X(av_image_fill_arrays)                                                                        \
    X(av_image_get_buffer_size)                                                                    \
    X(av_interleaved_write_frame)                                                                  \
    X(av_log_set_level)                                                                            \
    X(av_malloc)                                                                                   \
    X(av_mallocz)                                                                                  \
    X(av_new_packet)                                                                               \
    X(av_opt_set)                                                                                  \
    X(av_opt_set_double)                                                                           \
    X(av_opt_set_int)                                                                              \
    X(av_packet_alloc)                                                                             \
    X(av_packet_free)                                                                              \
    X(av_packet_new_side_data)                                                                     \
    X(av_packet_rescale_ts)                                                                        \
    X(av_packet_unref)                                                                             \
    X(av_pix_fmt_desc_get)                                                                         \
    X(av_read_frame)                                                                               \
    X(av_realloc_array)                                                                            \
    X(av_rescale_q)                                                                                \
    X(av_seek_frame)                                                                               \
    X(av_spherical_alloc)                                                                          \
    SC_LIBAV_SIDE_DATA(X)                                                                          \
    X(av_strerror)                                                                                 \
    X(av_write_frame)                                                                              \
    X(av_write_trailer)                                                                            \
    X(avcodec_alloc_context3)                                                                      \
    X(avcodec_find_decoder)                                                                        \
    X(avcodec_find_decoder_by_name)                                                                \
    X(avcodec_find_encoder)                                                                        \
    X(avcodec_find_encoder_by_name)                                                                \
    X(avcodec_flush_buffers)                                                                       \
    X(avcodec_free_context)                                                                        \
    X(avcodec_open2)                                                                               \
    X(avcodec_parameters_from_context)                                                             \
    X(avcodec_parameters_to_context)                                                               \
    X(avcodec_receive_frame)                                                                       \
    X(avcodec_receive_packet)                                                                      \
    X(avcodec_send_frame)                                                                          \
    X(avcodec_send_packet)                                                                         \
    X(avcodec_version)                                                                             \
    X(avformat_alloc_context)                                                                      \
    X(avformat_alloc_output_context2)                                                              \
    X(avformat_close_input)                                                                        \
    X(avformat_find_stream_info)                                                                   \
    X(avformat_free_context)                                                                       \
    X(avformat_new_stream)                                                                         \
    X(avformat_open_input)                                                                         \
    X(avformat_version)                                                                            \
    X(avformat_write_header)                                                                       \
    X(avio_alloc_context)                                                                          \
    X(avio_context_free)                                                                           \
    X(avio_flush)                                                                                  \
    X(sws_freeContext)                                                                             \
    X(sws_getCoefficients)                                                                         \
    X(sws_getContext)                                                                              \
    X(sws_scale)                                                                                   \
    X(sws_setColorspaceDetails)

#define SC_LIBAVFILTER_FUNCTIONS(X)                                                                \
    X(av_buffersink_get_frame)                                                                     \
    X(av_buffersrc_add_frame)                                                                      \
    X(av_buffersrc_add_frame_flags)                                                                \
    X(avfilter_get_by_name)                                                                        \
    X(avfilter_graph_alloc)                                                                        \
    X(avfilter_graph_config)                                                                       \
    X(avfilter_graph_create_filter)                                                                \
    X(avfilter_graph_free)                                                                         \
    X(avfilter_link)

/* The functions, by their own names; in front what must be as it was when segcast was built. */
typedef struct sc_libav {
    size_t bytes;          /* of this structure */
    unsigned av, av_codec; /* versions of the headers of libavformat and libavcodec */
#define SC_LIBAV_MEMBER(name) __typeof__(name) *(name);
    SC_LIBAV_FUNCTIONS(SC_LIBAV_MEMBER)
} sc_libav;

/* How segcast-libav.so is called. */
#define SC_LIBAV_FILE "segcast-libav.so"
/* What that file holds. In a program that is linked with libav, as those of the tests are, it is
 * part of the program; elsewhere its address is NULL. */
extern const sc_libav sc_libav_functions;

typedef struct sc_libavfilter {
    size_t bytes; /* of this structure */
    unsigned av;  /* version of the headers of libavfilter */
    SC_LIBAVFILTER_FUNCTIONS(SC_LIBAV_MEMBER)
} sc_libavfilter;

/* What segcast-libavfilter.so holds; as sc_libav_functions. */
extern const sc_libavfilter sc_libavfilter_functions;
/* Those functions; NULL until sc_libavfilter_is_here has been called, by any thread, or if they
 * cannot be loaded. */
extern const sc_libavfilter *sc_filters;
bool sc_libavfilter_is_here(void);
#undef SC_LIBAV_MEMBER

/* The functions; NULL until sc_libav_load or sc_libav_is_here has been called. */
extern const sc_libav *sc_av;
/* Load libav unless it is loaded. Any thread may call it. @param path of the video, for the
 * message. @return SC_ERR_CREATE, logged, if it cannot be loaded, SC_ERR_MEMORY. */
SC_MUST_USE sc_status sc_libav_load(const sc_ctx *ctx, const char *path);
/* As sc_libav_load. @return whether libav is loaded. */
bool sc_libav_is_here(void);

#endif
