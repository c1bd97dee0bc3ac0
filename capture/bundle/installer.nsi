; SPDX-License-Identifier: GPL-2.0-or-later
; The installer: the bundle for the current user, then `sistap install`. makensis -DVERSION= -DFOLDER= -DFILE=
Target amd64-unicode ; as the Python inside
ManifestDPIAware true
RequestExecutionLevel user
SetCompressor /SOLID lzma
SetDateSave off ; the same bytes each time

!define KEY "Software\Microsoft\Windows\CurrentVersion\Uninstall\sistap"

Name "sistap ${VERSION}"
OutFile "${FILE}"
InstallDir "$LOCALAPPDATA\Programs\sistap"
InstallDirRegKey HKCU "${KEY}" "InstallLocation"
ShowInstDetails show
ShowUninstDetails show

Page directory
Page instfiles
UninstPage uninstConfirm
UninstPage instfiles

; What the bundle has, so that nothing else in that folder is removed. A test compares it with the bundle.
!macro RemoveBundle
    RMDir /r "$INSTDIR\app"
    RMDir /r "$INSTDIR\experimental"
    RMDir /r "$INSTDIR\pictures"
    RMDir /r "$INSTDIR\python"
    Delete "$INSTDIR\install.cmd"
    Delete "$INSTDIR\uninstall.cmd"
    Delete "$INSTDIR\LICENSE.txt"
    Delete "$INSTDIR\LICENSE-pyserial.txt"
    Delete "$INSTDIR\LICENSE-python.txt"
    Delete "$INSTDIR\README.html"
    Delete "$INSTDIR\SIS.zip"
    Delete "$INSTDIR\sistap.exe"
!macroend

Section
    !insertmacro RemoveBundle
    SetOutPath "$INSTDIR"
    File /r "${FOLDER}/*"
    WriteUninstaller "$INSTDIR\uninstall.exe"
    WriteRegStr HKCU "${KEY}" "DisplayName" "sistap: SIS in Wireshark"
    WriteRegStr HKCU "${KEY}" "DisplayVersion" "${VERSION}"
    WriteRegStr HKCU "${KEY}" "InstallLocation" "$INSTDIR"
    WriteRegStr HKCU "${KEY}" "UninstallString" '"$INSTDIR\uninstall.exe"'
    WriteRegStr HKCU "${KEY}" "QuietUninstallString" '"$INSTDIR\uninstall.exe" /S'
    WriteRegDWORD HKCU "${KEY}" "NoModify" 1
    WriteRegDWORD HKCU "${KEY}" "NoRepair" 1
    CreateShortcut "$SMPROGRAMS\SIS in Wireshark.lnk" "$INSTDIR\README.html"
    nsExec::ExecToLog '"$INSTDIR\sistap.exe" install'
    Pop $0
    StrCmp $0 0 installed
    SetErrorLevel 1
    MessageBox MB_OK|MB_ICONEXCLAMATION "Wireshark does not have it yet; the details say why. Then start \
$INSTDIR\install.cmd again." /SD IDOK
installed:
SectionEnd

Section Uninstall
    nsExec::ExecToLog '"$INSTDIR\sistap.exe" uninstall'
    Pop $0
    StrCmp $0 0 taken
    MessageBox MB_YESNO|MB_ICONEXCLAMATION "Something is left in Wireshark's folders; the details say why. Remove \
sistap all the same?" /SD IDYES IDYES taken
    Abort
taken:
    !insertmacro RemoveBundle
    Delete "$SMPROGRAMS\SIS in Wireshark.lnk"
    Delete "$INSTDIR\uninstall.exe"
    RMDir "$INSTDIR"
    DeleteRegKey HKCU "${KEY}"
SectionEnd
