# SPDX-License-Identifier: GPL-2.0-or-later
"""`sistap tables`: captures as tables in Parquet files, to query months of many machines.

Rows of packets (rows), the columns (schema), the folder of tables (store), what happened (judging), adding captures
(convert). It may use all rooms but the other products. README.md has the columns, and queries in SQL.
"""
