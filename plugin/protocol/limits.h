/* SPDX-License-Identifier: GPL-2.0-or-later */
/* What the dissectors keep, show and accept.
 * Made by generate.py from limits.toml: edit there. */
/* clang-format off */

#ifndef PROTOCOL_LIMITS_H
#define PROTOCOL_LIMITS_H

/* Bytes of a packet in which bare telegrams may begin. Wireshark refuses a tree of more than a million
 * items, and a tap's queue holds 5,000. */
#define SIS_MOST_DISSECTED 32768

/* Transfers under way on one line; a device has one at a time. */
#define SIS_MOST_OPEN 256

/* Pieces of a transfer: 64 KB in pieces of 8 bytes. Wireshark searches all of them for each. */
#define SIS_MOST_PIECES 8192

/* Bytes of a list. More means that its last piece was lost. */
#define SIS_MOST_LIST 65535

/* Devices of one type that are asked for an attribute. More would say the same. */
#define SIS_MOST_TWINS 8

/* Elements of a list in the text of its value. */
#define SIS_SHOWN_IN_LIST 4

/* Elements of a list in the tree: more than a SERCOS list can have. Wireshark's limit is ten times that. */
#define SIS_SHOWN_IN_TREE 100000

/* Characters of a name in a node identification (chapter 3). */
#define SIS_MOST_CHARACTERS 40

/* Bytes of the memory in a reaction (chapter 5.4). */
#define SIS_MOST_READ 244

/* Bytes of the memory in a command (chapter 5.7). */
#define SIS_MOST_PROGRAMMED 240

/* Bytes of a parameter in a reaction (chapters 8.2 and 8.3). IndraDrive sends up to 245. */
#define SIS_MOST_PARAMETER_READ 236

/* Bytes of a parameter in a command (chapters 8.6 and 8.7). IndraDrive takes up to 243. */
#define SIS_MOST_PARAMETER_WRITTEN 234

/* Bytes of a command of Telnet. More means that its end was lost. */
#define SIS_MOST_TELNET 64

/* The time of a character at most, in ns: 12 bits at 9600 Bd. SIS knows no slower rate (chapter 7.1). */
#define SIS_LONGEST_CHARACTER 1250000

/* Bytes of a line of the ASCII protocol, as in capture/sistap/tap/records/framer.py. TCP waits for the
 * rest of fewer. */
#define SISASCII_MOST_LINE 4096

/* Tries to connect, and to send a block. */
#define P3964R_MOST_TRIES 6

/* The wait for an answer: Siemens' time, as SYNAX's own is not documented. */
#define P3964R_QVZ_MS 2000

/* The wait for the next try after a refusal. */
#define P3964R_BLOCK_WAIT_MS 4000

/* Words of data block 99 (page 8-8). */
#define RK512_MOST_IO_WORDS 32

/* Bytes of a command; for more, bit 1 of the info access is 0 (page 8-18). */
#define RK512_MOST_AT_ONCE 1024

/* Bytes of data in a telegram; what is more comes in follow-ups (page 8-29). */
#define RK512_MOST_IN_TELEGRAM 128

/* Bytes of data in the parameter channel: it has six words (SYNAX, page 3-3). */
#define SYNAXPK_MOST_DATA 10

#endif
