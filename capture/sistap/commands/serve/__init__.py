# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap serve`: a line of this computer is heard at others.

The command (command), who listens, and the reader that they hear (listeners). It is a capture that writes no file, so
that it reads, looks for a rate and says what is wrong as a capture does. It may use capture.
"""
