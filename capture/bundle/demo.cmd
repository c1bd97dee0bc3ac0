@echo off
rem Shows the telegrams of a simulated bus in Wireshark.
"%~dp0python\python.exe" -m sistap.dissected.wireshark.window -C SIS -k -i sistap-demo || pause
