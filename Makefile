.PHONY: demo test coverage dist
demo test coverage dist:
	@bash run.sh $@
