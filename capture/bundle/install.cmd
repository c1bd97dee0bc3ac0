@echo off
rem Puts dissector, interfaces and profile into the Wireshark of this user.
if not exist "%~dp0sistap.exe" (
    echo Unpack the whole zip first, then start install.cmd in its folder.
) else (
    "%~dp0sistap.exe" install
)
pause
