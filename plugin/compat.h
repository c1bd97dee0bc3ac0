/* SPDX-License-Identifier: GPL-2.0-or-later */
/* Every difference between Wireshark 4.0 and 4.6 that the plugin meets, and no other file has a version #if.
 */

#ifndef SIS_COMPAT_H
#define SIS_COMPAT_H

#include <stdbool.h>
#include <stdint.h>

#include <ws_version.h>
#include <epan/packet.h>
#include <wsutil/str_util.h> /* plurality() */

#define WIRESHARK_AT_LEAST(major, minor)                                                                     \
    (WIRESHARK_VERSION_MAJOR > (major) ||                                                                    \
     (WIRESHARK_VERSION_MAJOR == (major) && WIRESHARK_VERSION_MINOR >= (minor)))

/* true_false_string moved out of what packet.h brings along. */
#if WIRESHARK_AT_LEAST(4, 6)
#include <epan/tfs.h>
#endif

/* GLib's types in callbacks became C's: what a heuristic returns, and the functions of Decode As. */
#if WIRESHARK_AT_LEAST(4, 2)
typedef bool compat_bool;
typedef unsigned compat_uint;
typedef char compat_char;
typedef void *compat_pointer;
#else
typedef gboolean compat_bool;
typedef guint compat_uint;
typedef gchar compat_char;
typedef gpointer compat_pointer;
#endif

/* Plugins describe themselves from 4.2 on. */
#if __has_include(<wsutil/plugins.h>)
#include <wsutil/plugins.h>
#endif

/* What a bool preference is kept in. */
#if WIRESHARK_AT_LEAST(4, 4)
typedef bool compat_pref_bool;
#else
typedef gboolean compat_pref_bool;
#endif

#if WIRESHARK_AT_LEAST(4, 4)
#define compat_get_uint8(tvb, offset) tvb_get_uint8(tvb, offset)
#define compat_get_ntohl(tvb, offset) tvb_get_ntohl(tvb, offset)
#define COMPAT_STATS_MENU_SEPARATOR   "//"
#else
#define compat_get_uint8(tvb, offset) tvb_get_guint8(tvb, offset)
#define compat_get_ntohl(tvb, offset) tvb_get_ntohl(tvb, offset)
#define COMPAT_STATS_MENU_SEPARATOR   "/"
#endif

/* dissector_try_uint_new() is deprecated from 4.6 on. */
#if WIRESHARK_AT_LEAST(4, 6)
#define compat_try_uint(table, key, tvb, pinfo, tree, data)                                                  \
    dissector_try_uint_with_data(table, key, tvb, pinfo, tree, true, data)
#else
#define compat_try_uint(table, key, tvb, pinfo, tree, data)                                                  \
    dissector_try_uint_new(table, key, tvb, pinfo, tree, TRUE, data)
#endif

#endif
