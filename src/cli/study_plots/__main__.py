import importlib
import os
import sys

folder = os.path.dirname(os.path.abspath(__file__))
sys.path[0] = os.path.dirname(folder)
sys.exit(importlib.import_module(os.path.basename(folder) + ".program").run())
