/* SPDX-License-Identifier: GPL-2.0-or-later */
/* All differences between Wireshark 4.0 and 4.6 that concern the plugin: no other file has a version #if. */

#ifndef SIS_COMPAT_H
#define SIS_COMPAT_H

#include <stdbool.h>
#include <stdint.h>

#include <ws_version.h>
#include <epan/epan.h>
#include <epan/packet.h>
#include <wiretap/wtap.h>    /* wtap_rec: from 4.2 on packet.h no longer includes it */
#include <epan/tfs.h>        /* true_false_string: from 4.6 on packet.h no longer includes it */
#include <wsutil/str_util.h> /* plurality() */

/* The unit of a field; the units themselves are newer. */
#include <epan/unit_strings.h>
#ifndef UNS
#define UNS(units) (units)
#endif

#define WIRESHARK_AT_LEAST(major, minor)                                                                     \
    (WIRESHARK_VERSION_MAJOR > (major) ||                                                                    \
     (WIRESHARK_VERSION_MAJOR == (major) && WIRESHARK_VERSION_MINOR >= (minor)))

/* GLib's gboolean, an int, became C's bool, in callbacks and in preferences. */
#if WIRESHARK_AT_LEAST(4, 4)
typedef bool compat_bool;
#else
typedef gboolean compat_bool;
#endif

/* The same for the callbacks of a user table, earlier. */
#if WIRESHARK_AT_LEAST(4, 2)
typedef bool compat_uat_bool;
#else
typedef gboolean compat_uat_bool;
#endif

/* Plugins describe themselves from 4.4 on. */
#if WIRESHARK_AT_LEAST(4, 4)
#include <wsutil/plugins.h>
#define COMPAT_PLUGIN_DESCRIBE
#endif

#if WIRESHARK_AT_LEAST(4, 4)
#define compat_get_uint8(tvb, offset)            tvb_get_uint8(tvb, offset)
#define compat_get_uint16(tvb, offset, encoding) tvb_get_uint16(tvb, offset, encoding)
#define compat_get_uint32(tvb, offset, encoding) tvb_get_uint32(tvb, offset, encoding)
#else
#define compat_get_uint8(tvb, offset)            tvb_get_guint8(tvb, offset)
#define compat_get_uint16(tvb, offset, encoding) tvb_get_guint16(tvb, offset, encoding)
#define compat_get_uint32(tvb, offset, encoding) tvb_get_guint32(tvb, offset, encoding)
#endif

/* From 4.2 on, conversation filters have data of their own. */
#if WIRESHARK_AT_LEAST(4, 2)
#define COMPAT_CONVERSATION_DATA , void *data _U_
#define compat_register_conversation_filter(protocol, name, is_valid, build)                                 \
    register_conversation_filter(protocol, name, is_valid, build, NULL)
#else
#define COMPAT_CONVERSATION_DATA
#define compat_register_conversation_filter(protocol, name, is_valid, build)                                 \
    register_conversation_filter(protocol, name, is_valid, build)
#endif

/* Before 4.4, the menu Statistics would have two submenus SIS, one for trees of counts and one for the
 * others. */
#if WIRESHARK_AT_LEAST(4, 4)
#define COMPAT_IN_SUBMENU(title) "SIS//" title
#else
#define COMPAT_IN_SUBMENU(title) title
#endif

/* From 4.6 on, a statistic says whether it could begin. */
#if WIRESHARK_AT_LEAST(4, 6)
typedef bool compat_stat_begun;
#define COMPAT_STAT_BEGUN(begun) return (begun)
#else
typedef void compat_stat_begun;
#define COMPAT_STAT_BEGUN(begun) ((void)(begun))
#endif

/* dissector_try_uint_new() is deprecated from 4.6 on. */
#if WIRESHARK_AT_LEAST(4, 6)
#define compat_try_uint(table, key, tvb, pinfo, tree, data)                                                  \
    dissector_try_uint_with_data(table, key, tvb, pinfo, tree, true, data)
#else
#define compat_try_uint(table, key, tvb, pinfo, tree, data)                                                  \
    dissector_try_uint_new(table, key, tvb, pinfo, tree, TRUE, data)
#endif

/* The value at an offset. Versions after 4.6 have this form only. */
static inline bool
compat_find_uint8(tvbuff_t *tvb, unsigned offset, uint8_t value, unsigned *found)
{
#if WIRESHARK_AT_LEAST(4, 7)
    return tvb_find_uint8_remaining(tvb, offset, value, found);
#elif WIRESHARK_AT_LEAST(4, 4)
    int at = tvb_find_uint8(tvb, (int)offset, -1, value);
#else
    int at = tvb_find_guint8(tvb, (int)offset, -1, value);
#endif
#if !WIRESHARK_AT_LEAST(4, 7)
    *found = (unsigned)at;
    return at >= 0;
#endif
}

/* The packet's interface in its section; 0 if it has none. */
static inline uint32_t
compat_interface(const packet_info *pinfo)
{
    return pinfo->rec->presence_flags & WTAP_HAS_INTERFACE_ID
               ? pinfo->rec->rec_header.packet_header.interface_id
               : 0;
}

/* The packet's section in the capture, from 0. Every section has its own numbers of interfaces. */
static inline uint32_t
compat_section(const packet_info *pinfo)
{
    return pinfo->rec->presence_flags & WTAP_HAS_SECTION_NUMBER ? pinfo->rec->section_number : 0;
}

/* Its name; NULL if it has none. */
static inline const char *
compat_interface_name(const packet_info *pinfo)
{
    if (!(pinfo->rec->presence_flags & WTAP_HAS_INTERFACE_ID))
        return NULL;
#if WIRESHARK_AT_LEAST(4, 2)
    return epan_get_interface_name(pinfo->epan, compat_interface(pinfo), compat_section(pinfo));
#else
    return epan_get_interface_name(pinfo->epan, compat_interface(pinfo));
#endif
}

#endif
