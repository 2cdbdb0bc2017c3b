# IPython runs this file (PYTHONSTARTUP) at the start of a kernel that makes a page, among the
# page's names, and leaves none there.
__import__("runpy").run_path(__file__.replace("start_kernel", "names"))["keep"]()
