; SPDX-License-Identifier: GPL-2.0-or-later
; The installer: the bundle for the current user, then `sistap install`. makensis -DVERSION= -DFOLDER= -DFILE=
Target amd64-unicode ; as the Python inside
ManifestDPIAware true
RequestExecutionLevel user
SetCompressor /SOLID lzma
SetDateSave off ; the same bytes each time
!include MUI2.nsh

!define KEY "Software\Microsoft\Windows\CurrentVersion\Uninstall\sistap"
!define PUBLISHER "The authors of sistap"
!define MENU "$SMPROGRAMS\SIS in Wireshark"

Name "sistap ${VERSION}"
OutFile "${FILE}"
InstallDir "$LOCALAPPDATA\Programs\sistap"
InstallDirRegKey HKCU "${KEY}" "InstallLocation"
ShowInstDetails show
ShowUninstDetails show

VIProductVersion "${VERSION}.0"
VIAddVersionKey "CompanyName" "${PUBLISHER}"
VIAddVersionKey "FileDescription" "Installs sistap, a passive tap for SIS"
VIAddVersionKey "FileVersion" "${VERSION}"
VIAddVersionKey "LegalCopyright" "GPL-2.0-or-later"
VIAddVersionKey "ProductName" "sistap: SIS in Wireshark"
VIAddVersionKey "ProductVersion" "${VERSION}"

Var Result ; for the last page
!define MUI_FINISHPAGE_NOAUTOCLOSE
!define MUI_FINISHPAGE_TITLE "sistap ${VERSION} is on this computer"
!define MUI_FINISHPAGE_TEXT "$Result"
!define MUI_FINISHPAGE_TEXT_LARGE
!define MUI_FINISHPAGE_SHOWREADME "$INSTDIR\README.html"
!define MUI_FINISHPAGE_SHOWREADME_TEXT "Show what to do next"
!define MUI_FINISHPAGE_RUN
!define MUI_FINISHPAGE_RUN_TEXT "Show a simulated bus in Wireshark"
!define MUI_FINISHPAGE_RUN_FUNCTION Demo
!define MUI_FINISHPAGE_RUN_NOTCHECKED
!insertmacro MUI_PAGE_DIRECTORY
!insertmacro MUI_PAGE_INSTFILES
!insertmacro MUI_PAGE_FINISH
!insertmacro MUI_UNPAGE_CONFIRM
!insertmacro MUI_UNPAGE_INSTFILES
!insertmacro MUI_LANGUAGE English

; What the bundle has, so that nothing else in that folder is removed. A test compares it with the bundle.
!macro RemoveBundle
    RMDir /r "$INSTDIR\app"
    RMDir /r "$INSTDIR\docs"
    RMDir /r "$INSTDIR\experimental"
    RMDir /r "$INSTDIR\licences"
    RMDir /r "$INSTDIR\pictures"
    RMDir /r "$INSTDIR\python"
    Delete "$INSTDIR\CHECKLIST.html"
    Delete "$INSTDIR\LICENSE.txt"
    Delete "$INSTDIR\README.html"
    Delete "$INSTDIR\SIS.zip"
    Delete "$INSTDIR\demo.cmd"
    Delete "$INSTDIR\install.cmd"
    Delete "$INSTDIR\sis.html"
    Delete "$INSTDIR\sistap.exe"
    Delete "$INSTDIR\source.zip"
    Delete "$INSTDIR\uninstall.cmd"
!macroend

; Of earlier versions.
!macro RemoveOld
    Delete "$INSTDIR\LICENSE-pyserial.txt"
    Delete "$INSTDIR\LICENSE-python.txt"
    Delete "$SMPROGRAMS\SIS in Wireshark.lnk"
!macroend

; A page among the programs, if the bundle has it.
!macro Page FILE TITLE
    IfFileExists "$INSTDIR\${FILE}" 0 +2
    CreateShortcut "${MENU}\${TITLE}.lnk" "$INSTDIR\${FILE}"
!macroend

Function Demo
    ExecShell "open" "$INSTDIR\demo.cmd" "" SW_SHOWMINIMIZED
FunctionEnd

Section
    !insertmacro RemoveOld
    !insertmacro RemoveBundle
    SetOutPath "$INSTDIR"
    File /r "${FOLDER}/*"
    WriteUninstaller "$INSTDIR\uninstall.exe"
    WriteRegStr HKCU "${KEY}" "DisplayName" "sistap: SIS in Wireshark"
    WriteRegStr HKCU "${KEY}" "DisplayIcon" "$INSTDIR\uninstall.exe"
    WriteRegStr HKCU "${KEY}" "DisplayVersion" "${VERSION}"
    WriteRegStr HKCU "${KEY}" "Publisher" "${PUBLISHER}"
    WriteRegStr HKCU "${KEY}" "InstallLocation" "$INSTDIR"
    WriteRegStr HKCU "${KEY}" "UninstallString" '"$INSTDIR\uninstall.exe"'
    WriteRegStr HKCU "${KEY}" "QuietUninstallString" '"$INSTDIR\uninstall.exe" /S'
    WriteRegDWORD HKCU "${KEY}" "NoModify" 1
    WriteRegDWORD HKCU "${KEY}" "NoRepair" 1
    CreateDirectory "${MENU}"
    !insertmacro Page "README.html" "Read me first"
    !insertmacro Page "CHECKLIST.html" "Checklist, 15 minutes"
    !insertmacro Page "docs\index.html" "Documentation"
    !insertmacro Page "sis.html" "Captures and course in a browser"
    CreateShortcut "${MENU}\Demo.lnk" "$INSTDIR\demo.cmd" "" "" 0 SW_SHOWMINIMIZED
    CreateShortcut "${MENU}\Uninstall.lnk" "$INSTDIR\uninstall.exe"
    SetOutPath "$DOCUMENTS" ; where the prompt begins
    CreateShortcut "${MENU}\Command prompt.lnk" "$SYSDIR\cmd.exe" '/k "set "PATH=%PATH%;$INSTDIR"&sistap"'
    SetOutPath "$INSTDIR"
    nsExec::ExecToLog '"$INSTDIR\python\python.exe" -m sistap.commands.install.userpath add "$INSTDIR"'
    Pop $0
    nsExec::ExecToLog '"$INSTDIR\sistap.exe" install'
    Pop $0
    StrCpy $Result "Wireshark has SIS now. Start it, and choose the profile SIS at the right end of the status bar.$\r$\n\
$\r$\nIn a new command prompt, type sistap."
    StrCmp $0 0 installed
    SetErrorLevel 1
    StrCpy $Result "Wireshark does not have SIS yet. Start $INSTDIR\install.cmd: it says \
why.$\r$\n$\r$\nWithout Wireshark: in a new command prompt, type sistap."
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
    nsExec::ExecToLog '"$INSTDIR\python\python.exe" -m sistap.commands.install.userpath remove "$INSTDIR"'
    Pop $0
    SetOutPath "$TEMP"
    !insertmacro RemoveOld
    !insertmacro RemoveBundle
    RMDir /r "${MENU}"
    RMDir /r "$LOCALAPPDATA\sistap" ; results of self-tests
    Delete "$INSTDIR\uninstall.exe"
    RMDir "$INSTDIR"
    DeleteRegKey HKCU "${KEY}"
SectionEnd
