@echo off
rem Takes away what install.cmd has put.
"%~dp0sistap.exe" uninstall
pause
