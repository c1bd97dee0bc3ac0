"""later"""
def pulled(folder, runs_on): return ""
